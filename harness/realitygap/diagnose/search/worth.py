"""What makes a fitted suspect worth adding: it helps on motions that were not fitted, and its size is sure."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from realitygap.diagnose.candidates.suspects import neutral
from realitygap.diagnose.data.decoys import KNOWN
from realitygap.diagnose.data.problem import Change, Problem, Suspect
from realitygap.diagnose.fit.fit import Fit

VERY_FAR = 200.0
"""Above this no model comes near the floor, and one run in which the robot falls would decide: the median run does."""
MUCH = 0.15
"""Findings that leave this share of a gap, far from the floor, may be the wrong ones."""
GAIN = 0.10
"""A finding lowers the held-out cost above the floor by at least this share ..."""
LEAST = 0.12
"""... and by at least this much."""
CLEAR = 1.7
"""A mean squared residual up to this leaves nothing that is worth a name."""
FAR = 4.0
"""A mean squared residual above this is far from the floor: ..."""
HALF = 0.5
"""... then all findings together remove this share of it, or none is named."""
MORE, UNREPEATED = 0.6, 0.45
"""The same where no motion was repeated, and nearer to the floor, there for each finding too: what differs from one
repetition to the next is not known then, and something always fits it a little."""
BESIDE = 0.35
"""The share of what all others leave above the floor that a finding removes in the end."""
FRAGMENT = 0.05
"""Far from the floor a finding removes this share of the whole gap, or `BESIDE` of what was left before it."""


def gain(before: Fit, after: Fit, train: Sequence[int], judge: Sequence[int]) -> float:
    """How much of the cost is gone, on both kinds of motion, in log terms."""
    return lowered(before, after, judge) + lowered(before, after, train)


def lowered(before: Fit, after: Fit, cases: Sequence[int]) -> float:
    """How much lower the cost is, in log terms: of the mean, or very far from the floor of the median run."""
    if before.mean_cost(cases) > VERY_FAR:
        return float(np.median([np.log(before.cost[c] / after.cost[c]) for c in cases]))
    return float(np.log(before.mean_cost(cases) / after.mean_cost(cases)))


def removed(before: Fit, after: Fit, cases: Sequence[int]) -> float:
    """The share of a gap that is gone, of what stands above the floor."""
    was, left = before.mean_cost(cases), after.mean_cost(cases)
    return (was - left) / max(was - 1.0, 1e-9)


def refusal(before: Fit, after: Fit, train: Sequence[int], judge: Sequence[int]) -> str | None:
    """Why a fitted suspect does not help enough; None where it does."""
    was, now = before.mean_cost(judge), after.mean_cost(judge)
    little = was - now < LEAST or was - now < GAIN * max(was - 1.0, 0.0)
    if little and not (was > VERY_FAR and lowered(before, after, judge) > -np.log(1.0 - GAIN)):
        return f"held-out gap {rms(was):.2f} -> {rms(now):.2f}, too little"
    if after.mean_cost(train) > before.mean_cost(train) * (1 - 0.5 * GAIN):
        return "does not help on the training runs"
    worse = [c for c in judge if after.cost[c] > 1.2 * before.cost[c] + 0.3]
    if len(worse) * 2 > len(judge):
        return "makes most held-out runs worse"
    return None


def doubt(problem: Problem, assessed: Fit, judge: Sequence[int]) -> str | None:
    """Why a fit is not believed although it helps; None where it is. What it rests on is known once it is assessed."""
    newest = assessed.changes[-1]
    if (reason := absurd(newest)) is not None:
        return reason
    if not len(assessed.deviation):
        return None
    if not sized(problem, assessed, len(assessed.changes) - 1):
        return "its size cannot be told from none"
    last = [k for k, (i, _) in enumerate(assessed.names) if i == len(assessed.changes) - 1]
    zero = neutral(problem.plant, newest.suspect)
    if assessed.mean_cost(judge) > 2.0 and not _consistent(assessed, last, zero):
        return "no one value fits all runs"
    return None


def absurd(change: Change) -> str | None:
    """Why the values of a change are not its effect; None where they are."""
    why = KNOWN[change.suspect.effect].absurd
    return None if why is None else why(change.parameters)


def sized(problem: Problem, assessed: Fit, number: int) -> bool:
    """Whether the size of a change can be told from none, in one of its parameters at least."""
    zero = neutral(problem.plant, assessed.changes[number].suspect)
    return any(_certain(assessed, k, zero) for k, (i, _) in enumerate(assessed.names) if i == number)


def _certain(result: Fit, k: int, zero: dict[str, float]) -> bool:
    name = result.names[k][1]
    if not np.isfinite(zero[name]):
        return True
    return bool(abs(result.value[k] - zero[name]) > 2.5 * result.deviation[k])


def _consistent(result: Fit, last: Sequence[int], zero: dict[str, float]) -> bool:
    """Whether the runs, each on its own, would keep the value: an effect that is there is the same in all of them."""
    for k in last:
        name = result.names[k][1]
        if KNOWN[result.changes[-1].suspect.effect].parameter(name).shape:
            continue
        reference = abs(result.value[k] - zero[name]) if np.isfinite(zero[name]) else abs(result.value[k])
        weights = result.weight_per_case[:, k]
        telling = weights > 0.02 * weights.max(initial=0.0)
        if reference > 0 and telling.any():
            steps = np.abs(result.step_per_case[telling, k]) / reference
            if np.median(steps) < 0.5 and np.mean(steps < 1.0) >= 0.6:
                return True
    return False


def large(base: float, before: Fit, after: Fit, cases: Sequence[int]) -> bool:
    """Whether a finding is more than a fragment of a gap that was `base` at first, where a rest stays with it."""
    lower = before.mean_cost(cases) - after.mean_cost(cases)
    return lower >= FRAGMENT * (base - 1.0) or removed(before, after, cases) >= BESIDE


def stands(base: float, without: Fit, fitted: Fit, cases: Sequence[int], *, left: float, repeated: bool) -> bool:
    """Whether a finding removes enough of what all others leave.

    Args:
        base: the mean squared residual at first.
        without: the fit of all others.
        fitted: the fit with it.
        cases: that are judged on.
        left: the larger mean squared residual of training and judged motions with it.
        repeated: whether motions were repeated, so that the floor is known.
    """
    if repeated and left > FAR:
        return large(base, without, fitted, cases)
    share = UNREPEATED if not repeated and CLEAR < left <= FAR else BESIDE
    lower = without.mean_cost(cases) - fitted.mean_cost(cases)
    return removed(without, fitted, cases) >= share and lower >= LEAST


def explains(base: Fit, fitted: Fit, cases: Sequence[int], *, left: float, repeated: bool) -> bool:
    """Whether all findings together remove enough of a gap, very far from the floor in the median run; arguments as of
    `stands`.
    """
    if fitted.mean_cost(cases) > FAR:
        share = HALF if repeated else MORE
    else:
        share = 0.0 if repeated or left <= CLEAR else UNREPEATED
    if base.mean_cost(cases) > VERY_FAR:
        return lowered(base, fitted, cases) >= -float(np.log(1.0 - share))
    return removed(base, fitted, cases) >= share


def worst(problem: Problem, result: Fit) -> float:
    """The larger mean squared residual of the training and the held-out runs."""
    return max(result.mean_cost(problem.of(use)) for use in ("train", "held_out"))


def much_left(problem: Problem, base: Fit, result: Fit) -> bool:
    """Whether a fit leaves much of the gap of `base`, far from the floor."""
    shares = [result.mean_cost(part) / base.mean_cost(part) for part in map(problem.of, ("train", "held_out"))]
    return worst(problem, result) > FAR and max(shares) > MUCH


def rms(cost: float) -> float:
    """The gap of a cost: 1 is the floor."""
    return float(np.sqrt(cost))


def rank(problem: Problem, suspect: Suspect) -> float:
    """The place of a suspect in the table; on a linear axis without a stated armature, inertia is the link's mass."""
    order = list(KNOWN)
    joints, drive = problem.plant.model.joints, problem.plant.drive
    linear = suspect.effect == "rotor_inertia" and all(
        joints[i].prismatic and not drive["armature"][i] for i in suspect.indices
    )
    return order.index("link_mass") + 0.5 if linear else order.index(suspect.effect)
