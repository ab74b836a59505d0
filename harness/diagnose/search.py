"""The search: what explains most is added, judged on held-out motions, and dropped again where it became needless."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from harness.diagnose.decoys import DECOYS, KNOWN
from harness.diagnose.fit import Fit, assess, fit, start
from harness.diagnose.floors import set_floors
from harness.diagnose.pool import Pool
from harness.diagnose.problem import Change, Problem, Suspect
from harness.diagnose.screen import Screened, screen
from harness.diagnose.sensors import velocity_filters
from harness.diagnose.suspects import LATER, neutral, suspects

AT_FLOOR = 1.25
"""A mean squared residual up to this is what noise alone would give."""
CLOSE = (0.002, 0.4)
"""Nor is what is left of a gap, up to this share of it and this much, to be explained: no model is as exact."""
FITTED = 1.1
"""Training runs with a mean squared residual up to this tell nothing more, whatever the others leave."""
MOST = 6
"""Findings at most."""
MANY = 120
"""Suspects that are looked at again after the first round, at most."""
TRIED = 7
"""Suspects that are fitted per round."""
SURELY = 2
"""Suspects that are fitted at least ..."""
NEAR = 0.3
"""... and the share of the best one's explanation that the others must reach."""
EQUAL = 0.03
"""Gains within this share of the best are equal: then fewer parameters win, then the order of the table."""
FAR = 4.0
"""A mean squared residual above this is far from the floor: ..."""
VERY_FAR = 200.0
"""Above this no model comes near the floor, and one run in which the robot falls would decide: the median run does."""
HALF = 0.5
"""... then all findings together must remove this share of it, or none is named."""
GAIN = 0.10
"""A finding lowers the held-out cost above the floor by at least this share ..."""
LEAST = 0.12
"""... and by at least this much."""


@dataclass
class Step:
    """One accepted finding, what the held-out motions cost before and after, and all suspects as screened then."""

    suspect: Suspect
    before: float
    after: float
    ranked: list[Screened] = field(default_factory=list)


@dataclass
class Search:
    """What a search found.

    Attributes:
        base: the cost of the scenario's own model.
        fit: the accepted changes, jointly fitted.
        steps: in the order of acceptance.
        refused: sentences on suspects that were close and why they were not named.
    """

    base: Fit
    fit: Fit
    steps: list[Step] = field(default_factory=list)
    refused: list[str] = field(default_factory=list)


def search(pool: Pool, say: Callable[[str], None] = lambda _: None) -> Search:
    """Find the effects that explain the gap, by forward selection with exchange and removal."""
    problem = pool.problem
    train, judge = problem.of("train"), problem.of("held_out")
    set_floors(pool, [])
    base = fit(problem, [], train, judge)
    found = Search(base, base)
    everyone = suspects(problem)
    for change in velocity_filters(problem, everyone):  # the recordings show them and tell their size
        was, seen = found.fit, fit(problem, [*found.fit.changes, change], train, judge)
        if min(was.mean_cost(cases) - seen.mean_cost(cases) for cases in (train, judge)) > LEAST:
            say(f"added {name(change.suspect)}: the recorded velocity itself shows it")
            found.steps.append(Step(change.suspect, was.mean_cost(judge), seen.mean_cost(judge)))
            found.fit = seen
    while len(found.fit.changes) < MOST:
        now, kept = rms(found.fit.mean_cost(train)), rms(found.fit.mean_cost(judge))
        say(f"gap {now:.2f} on training runs, {kept:.2f} held out")
        left = [found.fit.mean_cost(part) - enough(base.mean_cost(part)) for part in (train, judge)]
        if max(left) <= 0.0 or (found.fit.changes and found.fit.mean_cost(train) <= FITTED):
            break
        possible = [s for s in everyone if not _clashes(s.effect, s.indices, found.fit.changes)]
        say(f"screening {len(possible)} suspects")
        ranked = screen(pool, possible, found.fit.changes, train)
        if len(everyone) > MANY:  # of a whole body, later rounds look at what the first one saw anything in
            everyone = [s.change.suspect for s in ranked[:MANY]]
        best = _best(pool, found, ranked, train, judge, say)
        if best is None:
            break
        step = Step(best.changes[-1].suspect, found.fit.mean_cost(judge), best.mean_cost(judge), ranked)
        say(f"added {name(best.changes[-1].suspect)}: held out {rms(step.before):.2f} -> {rms(step.after):.2f}")
        found.steps.append(step)
        found.fit = best
        set_floors(pool, best.changes)
        found.fit = _shaped(pool, found.fit, train, judge)
        found.fit = _pruned(pool, found, train, judge, say)
    if found.fit.changes:
        whole = _all_free(problem, found.fit, train, judge)
        found.fit = assess(problem, _settled(problem, whole, train, judge), train, judge)
    found.base = fit(problem, [], train, judge)
    _abstain_from_fragments(found, judge)
    return found


def enough(base: float) -> float:
    """The mean squared residual at which nothing is left to explain, of a gap that was `base`."""
    share, most = CLOSE
    return AT_FLOOR + min(share * max(base - 1.0, 0.0), most)


def _settled(problem: Problem, current: Fit, train: Sequence[int], judge: Sequence[int]) -> Fit:
    """The fit with what it leaves unexplained counted as noise, where that is far more than the sensors'."""
    left = current.mean_cost(train)
    return current if left <= FAR else fit(problem, current.changes, train, judge, misfit=rms(left))


def _all_free(problem: Problem, current: Fit, train: Sequence[int], judge: Sequence[int]) -> Fit:
    """The fit with what was told by the recordings fitted as well."""
    free = [replace(c, free=c.free or start(problem, c.suspect).free) for c in current.changes]
    return current if free == current.changes else fit(problem, free, train, judge)


def _abstain_from_fragments(found: Search, judge: Sequence[int]) -> None:
    """Name nothing where all that was found leaves most of the gap: what mends a little of it is not its cause."""
    was, left = found.base.mean_cost(judge), found.fit.mean_cost(judge)
    if found.fit.changes and left > FAR and was - left < HALF * (was - 1.0):
        for change in found.fit.changes:
            found.refused.append(
                f"{name(change.suspect)}: held-out gap {rms(was):.2f} -> {rms(left):.2f} with all findings: most of it "
                "has another cause"
            )
        found.fit, found.steps = found.base, []


def rms(cost: float) -> float:
    """The gap of a cost: 1 is the floor."""
    return float(np.sqrt(cost))


def name(suspect: Suspect) -> str:
    """An effect and its target, for people."""
    target = suspect.target if isinstance(suspect.target, str) else ", ".join(suspect.target)
    return f"{suspect.effect} at {target}{' (outside the list)' * (suspect.effect in DECOYS)}"


def _clashes(effect: str, indices: Sequence[int], accepted: Sequence[Change]) -> bool:
    """Whether an effect is already there, or excluded by one that is, at one of the targets."""
    for change in accepted:
        other = change.suspect
        if set(indices) & set(other.indices) and (
            effect == other.effect or effect in KNOWN[other.effect].excludes or other.effect in KNOWN[effect].excludes
        ):
            return True
    return False


def _best(
    pool: Pool,
    found: Search,
    ranked: Sequence[Screened],
    train: Sequence[int],
    judge: Sequence[int],
    say: Callable[[str], None],
) -> Fit | None:
    """The best fit with one more suspect; None where none is worth it."""
    problem = pool.problem
    tried = _varied(ranked)
    say("fitting " + ", ".join(name(s.change.suspect) for s in tried))
    fits = pool.map(fit, [([*found.fit.changes, s.change], train, judge) for s in tried])
    now = found.fit
    helping = [f for f in fits if _refusal(now, f, train, judge) is None]
    assessed = pool.map(assess, [(f, train, judge) for f in helping])
    worthy = [f for f in assessed if _doubt(problem, f, judge) is None]
    for candidate in [*(f for f in fits if f not in helping), *assessed]:
        reason = _refusal(now, candidate, train, judge) or _doubt(problem, candidate, judge)
        if reason and candidate.mean_cost(judge) < 0.8 * now.mean_cost(judge):
            found.refused.append(f"{name(candidate.changes[-1].suspect)}: {reason}")
    if not worthy:
        return None
    gains = [_gain(now, f, train, judge) for f in worthy]
    top = max(gains)
    equal = [f for f, g in zip(worthy, gains, strict=True) if g >= top - EQUAL * abs(top)]

    def simplicity(candidate: Fit) -> tuple[int, float]:
        last = candidate.changes[-1]
        return len(last.free), rank(problem, last.suspect)

    return min(equal, key=simplicity)


def rank(problem: Problem, suspect: Suspect) -> float:
    """The place of a suspect in the table; on a linear axis without a stated armature, inertia is the link's mass."""
    order = list(KNOWN)
    joints, drive = problem.plant.model.joints, problem.plant.drive
    linear = suspect.effect == "rotor_inertia" and all(
        joints[i].prismatic and not drive["armature"][i] for i in suspect.indices
    )
    return order.index("link_mass") + 0.5 if linear else order.index(suspect.effect)


def _varied(ranked: Sequence[Screened]) -> list[Screened]:
    """The best suspects, at most two starts of one and three targets of one effect, while they are near the best."""
    out: list[Screened] = []
    for s in ranked:
        if len(out) >= SURELY and s.explained < NEAR * ranked[0].explained:
            break
        same = [o for o in out if o.change.suspect == s.change.suspect]
        kin = [o for o in out if o.change.suspect.effect == s.change.suspect.effect]
        if len(same) < 2 and len(kin) < 3 and s.explained > 0.01:
            out.append(s)
        if len(out) == TRIED:
            break
    return out


def _gain(before: Fit, after: Fit, train: Sequence[int], judge: Sequence[int]) -> float:
    """How much of the cost is gone, on both kinds of motion, in log terms."""
    return _lowered(before, after, judge) + _lowered(before, after, train)


def _lowered(before: Fit, after: Fit, cases: Sequence[int]) -> float:
    """How much lower the cost is, in log terms: of the mean, or very far from the floor of the median run."""
    if before.mean_cost(cases) > VERY_FAR:
        return float(np.median([np.log(before.cost[c] / after.cost[c]) for c in cases]))
    return float(np.log(before.mean_cost(cases) / after.mean_cost(cases)))


def _refusal(before: Fit, after: Fit, train: Sequence[int], judge: Sequence[int]) -> str | None:
    """Why a fitted suspect does not help enough; None where it does."""
    was, now = before.mean_cost(judge), after.mean_cost(judge)
    little = was - now < LEAST or was - now < GAIN * max(was - 1.0, 0.0)
    if little and not (was > VERY_FAR and _lowered(before, after, judge) > -np.log(1.0 - GAIN)):
        return f"held-out gap {rms(was):.2f} -> {rms(now):.2f}, too little"
    if after.mean_cost(train) > before.mean_cost(train) * (1 - 0.5 * GAIN):
        return "does not help on the training runs"
    worse = [c for c in judge if after.cost[c] > 1.2 * before.cost[c] + 0.3]
    if len(worse) * 2 > len(judge):
        return "makes most held-out runs worse"
    return None


def _doubt(problem: Problem, assessed: Fit, judge: Sequence[int]) -> str | None:
    """Why a fit is not believed although it helps; None where it is. What it rests on is known once it is assessed."""
    newest = assessed.changes[-1]
    absurd = KNOWN[newest.suspect.effect].absurd
    if absurd is not None and (reason := absurd(newest.parameters)) is not None:
        return reason
    if not len(assessed.deviation):
        return None
    last = [k for k, (i, _) in enumerate(assessed.names) if i == len(assessed.changes) - 1]
    zero = neutral(problem.plant, newest.suspect)
    if not any(_certain(assessed, k, zero) for k in last):
        return "its size cannot be told from none"
    if assessed.mean_cost(judge) > 2.0 and not _consistent(assessed, last, zero):
        return "no one value fits all runs"
    return None


def _certain(result: Fit, k: int, zero: dict[str, float]) -> bool:
    name = result.names[k][1]
    if not np.isfinite(zero[name]):
        return True
    return bool(abs(result.value[k] - zero[name]) > 2.5 * result.deviation[k])


def _consistent(result: Fit, last: Sequence[int], zero: dict[str, float]) -> bool:
    """Whether the runs, each on its own, would keep the value: an effect that is there is the same in all of them."""
    for k in last:
        name = result.names[k][1]
        reference = abs(result.value[k] - zero[name]) if np.isfinite(zero[name]) else abs(result.value[k])
        weights = result.weight_per_case[:, k]
        telling = weights > 0.02 * weights.max(initial=0.0)
        if reference > 0 and telling.any():
            steps = np.abs(result.step_per_case[telling, k]) / reference
            if np.median(steps) < 0.5 and np.mean(steps < 1.0) >= 0.6:
                return True
    return False


def _shaped(pool: Pool, current: Fit, train: Sequence[int], judge: Sequence[int]) -> Fit:
    """The fit with the shape of the last finding freed, where that helps on held-out motions."""
    last = current.changes[-1]
    more = LATER.get(last.suspect.effect)
    if more is None:
        return fit(pool.problem, current.changes, train, judge)
    freed = [*current.changes[:-1], replace(last, free=more)]
    plain, rich = pool.map(fit, [(current.changes, train, judge), (freed, train, judge)])
    return rich if rich.mean_cost(judge) < 0.97 * plain.mean_cost(judge) else plain


def _pruned(pool: Pool, found: Search, train: Sequence[int], judge: Sequence[int], say: Callable[[str], None]) -> Fit:
    """The fit without findings that later ones made needless."""
    current = found.fit
    while len(current.changes) > 1:
        droppable = [c for c in current.changes[:-1] if c.free]  # what the recordings told stays
        if not droppable:
            return current
        without = [[c for c in current.changes if c is not drop] for drop in droppable]
        fits = pool.map(fit, [(rest, train, judge) for rest in without])
        best = min(range(len(fits)), key=lambda i: fits[i].mean_cost(judge))
        lost = fits[best].mean_cost(judge) - current.mean_cost(judge)
        if lost >= 0.5 * LEAST and lost >= 0.5 * GAIN * max(fits[best].mean_cost(judge) - 1.0, 0.0):
            return current
        needless = droppable[best].suspect
        say(f"dropped {name(needless)}: needless now")
        found.steps = [s for s in found.steps if s.suspect != needless]
        current = fits[best]
    return current
