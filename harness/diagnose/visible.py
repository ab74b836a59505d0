"""From which size on recordings could show an effect, and what they could take it for: told from signatures alone.

A signature is how an effect moves the traces, in floors. Its mean square is what the effect adds to the mean squared
residual, so its size tells from when on a search would notice, and the angle between two signatures tells how much of
one effect another one could explain.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import lsq_linear

from harness.diagnose.planting import planted
from harness.diagnose.pool import Pool
from harness.diagnose.problem import WORST, Change, Problem, Suspect
from harness.diagnose.rivals import SAME_COST
from harness.diagnose.screen import SHAPES
from harness.diagnose.search import AT_FLOOR, LEAST
from harness.diagnose.suspects import neutral, whole
from harness.drive import Array
from harness.effects import EFFECTS

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
"""Entries of a signature that are kept for comparing it with others."""


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


def visible(pool: Pool, suspects: Sequence[Suspect], quiet: tuple[float, float]) -> list[Visible]:
    """The smallest size of every suspect that a search would see.

    Args:
        pool: of the problem, with its floors set.
        suspects: what to plant.
        quiet: the mean squared residual without any effect, on training and on held-out runs.
    """
    tried: dict[Suspect, list[tuple[float, float]]] = {s: [] for s in suspects}
    factor = dict.fromkeys(suspects, 1.0)
    open_ = list(suspects)
    for _ in range(ROUNDS):
        answers = pool.map(_strengths, [(planted(pool.problem, s, factor[s]),) for s in open_])
        for s, (train, judge, _) in zip(open_, answers, strict=True):
            tried[s].append((factor[s], _ratio(train, judge, quiet)))
            factor[s] = _next(tried[s])
        open_ = [s for s in open_ if not CLOSE[0] <= tried[s][-1][1] <= CLOSE[1] and factor[s] != tried[s][-1][0]]
        if not open_:
            break
    found = {s: _nearest(tried[s]) for s in suspects}
    answers = pool.map(_bases, [(planted(pool.problem, s, found[s][0]),) for s in suspects])
    out = []
    for s, (strength, signature, basis, one_sided) in zip(suspects, answers, strict=True):
        size, ratio = found[s]
        change = planted(pool.problem, s, size)
        seen = size if ratio >= CLOSE[0] else np.inf
        out.append(Visible(s, seen, change, strength, signature, basis, one_sided))
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
    return float(min(rest @ rest / max(a.signature @ a.signature, 1e-30), 1.0))


def _ratio(train: float, judge: float, quiet: tuple[float, float]) -> float:
    """The mean square of a signature over what is needed to be seen, and to be judged on held-out runs."""
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


def _strengths(problem: Problem, change: Change) -> tuple[float, float, list[Array]]:
    """What a change adds to the mean squared residual of training and held-out runs, and the change of each run's."""
    moved = []
    for i in range(len(problem.cases)):
        here, there = problem.residuals([change], i), problem.residuals([], i)
        failed = np.abs(here).max() >= WORST / 1e3
        moved.append(np.zeros_like(here) if failed else here - there)
    train, judge = (float(np.mean([np.mean(moved[i] ** 2) for i in problem.of(use)])) for use in ("train", "held_out"))
    return train, judge, moved


def _bases(problem: Problem, change: Change) -> tuple[float, Array, Array, Array]:
    """Strength, signature and basis of a change at its size; see `Visible`."""
    train, judge, moved = _strengths(problem, change)
    signature = _joined(problem, moved)
    probes = _probes(problem, change)
    columns = [signature if p == change else _joined(problem, _strengths(problem, p)[2]) for p, _ in probes]
    return 0.5 * (train + judge), signature, np.column_stack(columns), np.array([one_sided for _, one_sided in probes])


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


def _joined(problem: Problem, moved: Sequence[Array]) -> Array:
    """The runs' residuals as one vector in which every run counts alike, thinned."""
    stride = max(1, sum(len(m) for m in moved) // SAMPLES)
    return np.concatenate([m[::stride] / np.sqrt(max(len(m[::stride]), 1)) for m in moved]) / np.sqrt(
        len(problem.cases)
    )
