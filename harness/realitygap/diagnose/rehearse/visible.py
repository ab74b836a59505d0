"""From which size on recordings show an effect, and what they could take it for: told from signatures alone.

A signature is how an effect moves the residual, whitened. Half its square is the evidence that the effect gives beside
floors alone, which tells from which size on it shows; a search knows that laws are only nearly right, and names less.
The angle between two signatures tells how much of one effect another one could explain.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from realitygap.diagnose.candidates.starts import sized
from realitygap.diagnose.candidates.suspects import neutral, whole
from realitygap.diagnose.data.changes import Change, Suspect
from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.fit.bounded import bounded
from realitygap.diagnose.fit.demanded import demanded
from realitygap.diagnose.fit.motions import Motions
from realitygap.diagnose.likelihood.floors import Floors
from realitygap.diagnose.likelihood.whitening import Whitening, channels, effective_fraction
from realitygap.diagnose.rehearse.planting import planted
from realitygap.diagnose.search.discrepancy import SHARE
from realitygap.diagnose.search.rivals import ODDS
from realitygap.robot.drive import Array

CLEARLY = 1.5
"""An effect is seen where its evidence is larger than what a name needs by this factor."""
ROUNDS = 4
"""Sizes that are simulated at most to find the smallest that is seen."""
LARGEST, SMALLEST = 64.0, 1e-3
"""Sizes that are tried, in first sizes."""
WITHIN = (0.85, 1.4)
"""The smallest size is found when its evidence is this close to what is needed."""
TWIN = 2e-3
"""Two signatures with less than this share of one outside the other are the same: no size tells them apart."""


@dataclass
class Visible:
    """The smallest size at which one effect at one target is seen.

    Attributes:
        suspect: the effect and where it sits.
        factor: the size, in first sizes; infinite where even the largest is not seen.
        change: the effect at that size (at the largest that was tried where it is not seen).
        signature: its change of the training residual there, whitened. Shape (m,).
        basis: one signature for each parameter that is fitted. Shape (m, p).
        one_sided: which of them cannot be followed backwards. Shape (p,).
    """

    suspect: Suspect
    factor: float
    change: Change
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
    simulations: Simulations,
    floors: Floors,
    suspects: Sequence[Suspect],
    limit: float,
    say: Callable[[str], None] = lambda _: None,
) -> list[Visible]:
    """The smallest size of every suspect that shows beside the floors.

    Args:
        simulations: of the problem.
        floors: of its model.
        suspects: what to plant.
        limit: the evidence that a name needs.
        say: told what is being done.

    Raises:
        InputError: for a scenario whose own model cannot be simulated.
    """
    problem = simulations.problem
    look = Look(simulations, floors)
    tried: dict[Suspect, list[tuple[float, float]]] = {s: [] for s in suspects}
    factor = dict.fromkeys(suspects, 1.0)
    open_ = list(suspects)
    for number in range(ROUNDS):
        say(f"simulating {len(open_)} effects at their size number {number + 1}")
        signatures = look.signatures([planted(problem, s, factor[s]) for s in open_])
        for s, signature in zip(open_, signatures, strict=True):
            tried[s].append((factor[s], 0.5 * float(signature @ signature) / (CLEARLY * limit)))
            factor[s] = _next(tried[s])
        open_ = [s for s in open_ if not WITHIN[0] <= tried[s][-1][1] <= WITHIN[1] and factor[s] != tried[s][-1][0]]
        if not open_:
            break
    found = {s: _nearest(tried[s]) for s in suspects}
    least = {s: planted(problem, s, found[s][0]) for s in suspects}
    probes = {s: _probes(problem, least[s]) for s in suspects}
    asked = list(dict.fromkeys(c for s in suspects for c in (least[s], *(p for p, _ in probes[s]))))
    say(f"simulating {len(asked)} changes of single parameters at the smallest sizes")
    parts = dict(zip(asked, look.signatures(asked), strict=True))
    out = []
    for s in suspects:
        size, ratio = found[s]
        basis = np.column_stack([parts[p] for p, _ in probes[s]])
        one_sided = np.array([only_up for _, only_up in probes[s]])
        seen = size if ratio >= WITHIN[0] else np.inf
        out.append(Visible(s, seen, least[s], parts[least[s]], basis, one_sided))
    return out


class Look:
    """Signatures: how changes move the training residual, whitened by the floors alone."""

    def __init__(self, simulations: Simulations, floors: Floors) -> None:
        train = simulations.problem.of("train")
        self.motions = Motions(simulations, train, floors.coarse)
        demanded(simulations, [], train)
        self.channels = tuple(channels(simulations.problem, floors, train))
        random = np.random.default_rng(0)
        self.noise = np.concatenate([c.noise * random.standard_normal(len(c.time)) for c in self.channels])

    def signatures(self, changes: Sequence[Change]) -> list[Array]:
        """Of each change alone, shape (m,); zero where it cannot be simulated, which says nothing of the real robot."""
        still, *answers = self.motions.residuals([[], *([c] for c in changes)])
        assert still is not None
        columns = [np.zeros(len(still)) if a is None else np.nan_to_num(a - still) for a in answers]
        return [self._white(column, np.isfinite(still).astype(float)) for column in columns]

    def _white(self, column: Array, weight: Array) -> Array:
        """Whitened, and as long as what would be recorded has effective samples: the change and the sensors' noise."""
        few = effective_fraction(self.channels, column + self.noise)
        plain = Whitening(self.channels, np.zeros(len(few)), np.ones(len(few)))(column[:, None], weight)[0][:, 0]
        counted = plain * np.sqrt(np.repeat(few, [len(c.time) for c in self.channels]))
        return np.asarray(plain * np.linalg.norm(counted) / max(float(np.linalg.norm(plain)), 1e-30))


def within_law(problem: Problem, change: Change) -> float:
    """The share to which laws of an effect's kind are known, where what it changes of the model's own values is no more
    than that: recordings show it, and no diagnosis names it. 0 where it is more, or the model has nothing of it.
    """
    zero, share = neutral(problem.plant, change.suspect), SHARE.get(change.suspect.kind.law, 0.0)
    moved = [
        p.name for p in change.suspect.kind.parameters if not p.shape and change.parameters[p.name] != zero[p.name]
    ]
    if not all(np.isfinite(zero[n]) and zero[n] for n in moved):
        return 0.0
    most = max((abs(change.parameters[n] / zero[n] - 1.0) for n in moved), default=np.inf)
    return share if most <= share else 0.0


def confusables(found: Sequence[Visible]) -> list[Confusable]:
    """For every effect that is seen, what else explains part of it, the hardest to tell apart first."""
    seen = [v for v in found if v.seen]
    out = []
    for a in seen:
        for b in seen:
            if a is b or not _different(a.suspect, b.suspect):
                continue
            rest = _unexplained(a, b)
            left = 0.5 * rest * float(a.signature @ a.signature)
            apart = a.factor * float(np.sqrt(ODDS / max(left, 1e-30))) if rest > TWIN else np.inf
            out.append(Confusable(a.suspect, b.suspect, 1.0 - rest, apart))
    return sorted(out, key=lambda c: -c.share)


def _different(a: Suspect, b: Suspect) -> bool:
    """Not one effect at a joint and at a pattern that means this joint alone."""
    return not (a.effect == b.effect and a.indices == b.indices)


def _unexplained(a: Visible, b: Visible) -> float:
    """The share of a's signature that b's parameters leave, followed along straight lines."""
    low = np.where(b.one_sided, 0.0, -np.inf)
    rest = a.signature - b.basis @ bounded(b.basis, a.signature, low, np.full(len(low), np.inf))
    return min(float(rest @ rest) / max(float(a.signature @ a.signature), 1e-30), 1.0)


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
    enough = [t for t in tried if t[1] >= WITHIN[0]]
    return min(enough, key=lambda t: t[1]) if enough else max(tried, key=lambda t: t[1])


def _probes(problem: Problem, change: Change) -> list[tuple[Change, bool]]:
    """A change of each of its parameters alone, and whether it cannot be less than nothing, as a friction cannot."""
    effect, zero = change.suspect.kind, neutral(problem.plant, change.suspect)
    if "phase" in change.free:
        turned = change.parameters["phase"] + np.pi / 2
        return [(change, False), (change.at({"phase": turned}), False)]
    moved = [p.name for p in sized(change) if change.parameters[p.name] != zero[p.name]]
    one_sided = {n: not np.isfinite(zero[n]) or zero[n] <= effect.parameter(n).low for n in moved}
    if len(moved) < 2 or whole(effect):
        return [(change, whole(effect) or any(one_sided.values()))]
    return [(change.at({n: zero[n] for n in moved if n != keep}), one_sided[keep]) for keep in moved]
