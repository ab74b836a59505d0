"""From which size on recordings could show an effect, and what they could take it for: told from signatures alone.

A signature is how an effect moves the traces, in floors. Its mean square is what the effect adds to the mean squared
residual, so its size tells from when on a search would notice, and the angle between two signatures tells how much of
one effect another one could explain.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import lsq_linear

from realitygap.diagnose.candidates.suspects import neutral, whole
from realitygap.diagnose.data.pool import Pool
from realitygap.diagnose.data.problem import WORST, Change, Problem, Suspect
from realitygap.diagnose.fit.probes import SHAPES
from realitygap.diagnose.judge.rivals import SAME_COST
from realitygap.diagnose.rehearse.planting import planted
from realitygap.diagnose.search.search import AT_FLOOR
from realitygap.diagnose.search.worth import LEAST
from realitygap.robot.drive import Array
from realitygap.robot.effects import EFFECTS

CLEARLY = 1.5
"""A gap is seen where it is larger than the least that the search looks at by this factor (in the mean square)."""
ROUNDS = 4
"""Sizes that are simulated at most to find the smallest that is seen."""
LARGEST, SMALLEST = 64.0, 1e-3
"""Sizes that are tried, in first sizes."""
CLOSE = (0.85, 1.4)
"""The smallest size is found when its mean square is this close to what is needed."""
TWIN = 2e-3
"""Two signatures with less than this share of one outside the other are the same: no size tells them apart."""
SAMPLES = 60_000
"""Entries of a signature that are kept, about."""


@dataclass
class Visible:
    """The smallest size at which one effect at one target is seen.

    Attributes:
        suspect: the effect and where it sits.
        factor: the size, in first sizes; infinite where even the largest is not seen.
        change: the effect at that size (at the largest that was tried where it is not seen).
        strength: what it adds there to the mean squared residual, over all runs.
        signature: its change of the residual there. Shape (samples,), every run with the same weight.
        basis: one signature for each parameter that is fitted. Shape (samples, p).
        one_sided: which of them cannot be followed backwards. Shape (p,).
    """

    suspect: Suspect
    factor: float
    change: Change
    strength: float
    signature: Array
    basis: Array
    one_sided: Array

    @property
    def seen(self) -> bool:
        """Whether any size is seen."""
        return bool(np.isfinite(self.factor))


@dataclass(frozen=True)
class Confusable:
    """What one effect can be taken for.

    Attributes:
        planted, other: the effect, and what explains it.
        share: of the mean square of the planted one's signature that the other explains.
        apart_from: the size of the planted one from which on they are told apart, in first sizes; infinite for twins.
    """

    planted: Suspect
    other: Suspect
    share: float
    apart_from: float


def visible(
    pool: Pool, suspects: Sequence[Suspect], quiet: tuple[float, float], say: Callable[[str], None] = lambda _: None
) -> list[Visible]:
    """The smallest size of every suspect that a search would see.

    Args:
        pool: of the problem, with its floors set.
        suspects: what to plant.
        quiet: the mean squared residual without any effect, on training and on held-out runs.
        say: told what is being done.
    """
    problem = pool.problem
    still = _residuals(problem, ())
    tried: dict[Suspect, list[tuple[float, float]]] = {s: [] for s in suspects}
    factor = dict.fromkeys(suspects, 1.0)
    open_ = list(suspects)
    for number in range(ROUNDS):
        say(f"simulating {len(open_)} effects at their size number {number + 1}")
        answers = pool.map(_residuals, [((planted(problem, s, factor[s]),),) for s in open_])
        for s, answer in zip(open_, answers, strict=True):
            tried[s].append((factor[s], _ratio(problem, _moved(answer, still), quiet)))
            factor[s] = _next(tried[s])
        open_ = [s for s in open_ if not CLOSE[0] <= tried[s][-1][1] <= CLOSE[1] and factor[s] != tried[s][-1][0]]
        if not open_:
            break
    found = {s: _nearest(tried[s]) for s in suspects}
    limit, probes = {}, {}
    for s in suspects:
        limit[s] = planted(problem, s, found[s][0])
        probes[s] = _probes(problem, limit[s])
    questions = dict.fromkeys(c for s in suspects for c in (limit[s], *(p for p, _ in probes[s])))
    say(f"simulating {len(questions)} changes of single parameters at the smallest sizes")
    parts = dict(zip(questions, pool.map(_residuals, [((c,),) for c in questions]), strict=True))
    out = []
    for s in suspects:
        size, ratio = found[s]
        moved = _moved(parts[limit[s]], still)
        basis = np.column_stack([_joined(_moved(parts[p], still)) for p, _ in probes[s]])
        strength = float(np.mean([np.mean(m**2) for m in moved]))
        seen = size if ratio >= CLOSE[0] else np.inf
        one_sided = np.array([only_up for _, only_up in probes[s]])
        out.append(Visible(s, seen, limit[s], strength, _joined(moved), basis, one_sided))
    return out


def confusables(found: Sequence[Visible]) -> list[Confusable]:
    """For every effect that is seen, what else explains part of it, the hardest to tell apart first."""
    seen = [v for v in found if v.seen]
    out = []
    for a in seen:
        for b in seen:
            if a is b or not _different(a.suspect, b.suspect):
                continue
            rest = _unexplained(a, b)
            apart = a.factor * float(np.sqrt(SAME_COST / max(rest * a.strength, 1e-30))) if rest > TWIN else np.inf
            out.append(Confusable(a.suspect, b.suspect, 1.0 - rest, apart))
    return sorted(out, key=lambda c: -c.share)


def _different(a: Suspect, b: Suspect) -> bool:
    """Not one effect at a joint and at a pattern that means this joint alone."""
    return not (a.effect == b.effect and a.indices == b.indices)


def _unexplained(a: Visible, b: Visible) -> float:
    """The share of a's signature that b's parameters leave, followed along straight lines."""
    low = np.where(b.one_sided, 0.0, -np.inf)
    solution = lsq_linear(b.basis, a.signature, bounds=(low, np.inf), method="bvls", max_iter=50)
    rest = a.signature - b.basis @ solution.x
    return min(float(rest @ rest) / max(float(a.signature @ a.signature), 1e-30), 1.0)


def _ratio(problem: Problem, moved: Sequence[Array], quiet: tuple[float, float]) -> float:
    """The mean square of a signature over what is needed to be seen, and to be judged on held-out runs."""
    train, judge = (float(np.mean([np.mean(moved[i] ** 2) for i in problem.of(use)])) for use in ("train", "held_out"))
    noticed = max(train / max(AT_FLOOR - quiet[0], LEAST), judge / max(AT_FLOOR - quiet[1], LEAST))
    return min(noticed, judge / LEAST) / CLEARLY


def _next(tried: Sequence[tuple[float, float]]) -> float:
    """The next size to try: along the slope of the last two in logarithms, at first that of a square."""
    factor, ratio = tried[-1]
    if ratio <= 0:
        return min(8.0 * factor, LARGEST)
    slope = 2.0
    if len(tried) > 1 and tried[-2][1] > 0 and tried[-2][0] != factor:
        slope = float(np.log(ratio / tried[-2][1]) / np.log(factor / tried[-2][0]))
    step = float(np.clip(ratio ** (-1.0 / np.clip(slope, 0.7, 4.0)), 1 / 64, 64))
    return float(np.clip(1.05 * factor * step, SMALLEST, LARGEST))


def _nearest(tried: Sequence[tuple[float, float]]) -> tuple[float, float]:
    """The size closest to what is needed among those that are seen; the strongest where none is."""
    enough = [t for t in tried if t[1] >= CLOSE[0]]
    return min(enough, key=lambda t: t[1]) if enough else max(tried, key=lambda t: t[1])


def _residuals(problem: Problem, changes: tuple[Change, ...]) -> list[Array]:
    """The residual of every run, thinned where there are very many samples."""
    runs = range(len(problem.cases))
    stride = max(1, sum(problem.length(i) for i in runs) // SAMPLES)
    return [problem.residuals(changes, i)[::stride] for i in runs]


def _moved(here: Sequence[Array], still: Sequence[Array]) -> list[Array]:
    """The change of every run's residual; none where the simulation failed, which says nothing of the real robot."""
    return [np.zeros_like(s) if np.abs(h).max() >= WORST / 1e3 else h - s for h, s in zip(here, still, strict=True)]


def _probes(problem: Problem, change: Change) -> list[tuple[Change, bool]]:
    """A change of each of its parameters alone, and whether it cannot be less than nothing, as a friction cannot."""
    effect, zero = EFFECTS[change.suspect.effect], neutral(problem.plant, change.suspect)
    if effect.name == "torque_ripple":
        turned = change.parameters["phase"] + np.pi / 2
        return [(change, False), (_with(change, {"phase": turned}), False)]
    moved = [n for n in change.free if n not in SHAPES and change.parameters[n] != zero[n]]
    one_sided = {n: not np.isfinite(zero[n]) or zero[n] <= effect.parameter(n).low for n in moved}
    if len(moved) < 2 or whole(effect):
        return [(change, whole(effect) or any(one_sided.values()))]
    return [(_with(change, {n: zero[n] for n in moved if n != keep}), one_sided[keep]) for keep in moved]


def _with(change: Change, values: dict[str, float]) -> Change:
    return replace(change, values=tuple((change.parameters | values).items()))


def _joined(moved: Sequence[Array]) -> Array:
    """The runs' residuals as one vector in which every run counts alike."""
    return np.asarray(np.concatenate([m / np.sqrt(len(m) * len(moved)) for m in moved]))
