"""Moves at a glance: what adding suspects would gain, in the linearised model of their responses.

All from one Gram matrix in the metric of the residual, orthogonalised on what is already in (a Schur complement): a
suspect that does the same as an accepted value, or as a law discrepancy, gains nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from realitygap.diagnose.data.changes import Change, Suspect, clash
from realitygap.diagnose.fit.bounded import bounded
from realitygap.diagnose.fit.responses import Block
from realitygap.diagnose.fit.space import SLAB, negative_log_prior
from realitygap.diagnose.likelihood.metric import Metric
from realitygap.diagnose.search.evidence import Scored
from realitygap.robot.drive import Array

NOWHERE, BESIDE = 1e-9, 1e-6
"""The curvature that every amount has at least, and that of what is beside the origin of a centre: along an axis of
which no motion tells where a load is, it lies at its link's frame, and not halfway to where it was tried."""
SILENT = 1e-3
"""A response shorter than so many standard deviations of all samples together answers by rounding alone: it has the
curvature of its prior, and so no amount. The axes of a pan and tilt meet in the frame, where a mass does nothing: a
load of 0.15 kg began as 1.9 kg at 3 mm or as 8 g at 1 m, and as 0.09 kg at its place with this."""
LOOKED = 8
"""Blocks whose gain beside others is worked out within all bounds, of those that gain most roughly."""


@dataclass(frozen=True)
class LinearGain:
    """A start with the amounts that fit best in the linearised model, and the gain in evidence that this predicts."""

    block: Block
    amounts: tuple[float, ...]
    gain: float

    @property
    def change(self) -> Change:
        """The suspect at these amounts."""
        return self.block.start.at(self.amounts)


class Linear:
    """The linearised (Gauss-Newton) model around an accepted model, in amounts of the responses.

    Args:
        metric: of the residual.
        residual: of the accepted model. Shape (m,).
        slope: of its fitted values. Shape (m, p).
        blocks: responses of the suspects.
    """

    def __init__(self, metric: Metric, residual: Array, slope: Array, blocks: Sequence[Block]) -> None:
        self.blocks = list(blocks)
        columns, p = [residual, slope, *(b.columns for b in blocks)], slope.shape[1]
        gram = metric.gram([c for c in columns if c.ndim == 1 or c.shape[1]])
        own, rest = slice(1, p + 1), np.delete(np.arange(len(gram)), slice(1, p + 1))
        if p:  # what a change of the accepted values would do is no gain of a suspect's
            beside = cho_solve(cho_factor(gram[own, own] + np.eye(p) / SLAB**2), gram[own])
            gram = gram - gram[:, own] @ beside
        self.gram = gram[np.ix_(rest, rest)]
        ends = np.cumsum([1, *(b.columns.shape[1] for b in blocks)])
        self.places = [np.arange(a, b) for a, b in pairwise(ends)]
        reach = [b.start.reach(k) for b in blocks for k in range(b.columns.shape[1])]
        self.low, self.high = np.array([r[0] for r in reach]), np.array([r[1] for r in reach])
        off_centre = [b.start.kind == "centre" and k > 0 for b in blocks for k in range(b.columns.shape[1])]
        least = np.where(off_centre, BESIDE, NOWHERE)
        self.least = np.where(np.diag(self.gram)[1:] < SILENT**2, 1.0 / SLAB**2, least)
        self._clashes: dict[int, Array] = {}

    def gain_of(self, number: int) -> LinearGain:
        """What one block gains alone."""
        return LinearGain(self.blocks[number], tuple(self._amounts([number]).tolist()), self._gain([number]))

    def toward(self, number: int) -> float:
        """What a block of one response gains at the best part of it: of a limit that is too tight, and as it is would
        be worse than none, whether it leads the right way.
        """
        (at,) = self.places[number]
        slope, curve = -float(self.gram[at, 0]), float(self.gram[at, at])
        part = float(np.clip(slope / curve, 0.0, 1.0)) if curve > 0.0 else 0.0
        return part * slope - 0.5 * part**2 * curve

    def limits(self) -> dict[Suspect, Change]:
        """What is far from linear and leads the right way, as little of it as would; best first, each as the
        try that leads furthest.
        """
        numbers = [i for i, b in enumerate(self.blocks) if b.start.kind == "whole"]
        tried = sorted(((self.toward(i), i) for i in numbers), reverse=True)
        best: dict[Suspect, Change] = {}
        for i in (i for gain, i in tried if gain > 0.0):
            best.setdefault(self.blocks[i].suspect, self.blocks[i].start.tries[0])
        return best

    def gains(self) -> list[LinearGain]:
        """What every block gains alone, best first."""
        return sorted((self.gain_of(i) for i in range(len(self.blocks))), key=lambda p: -p.gain)

    def gain(self, numbers: Sequence[int], tried: int | None = None) -> float:
        """The gain in evidence of some blocks at once, at most: without an Occam factor for what they could do besides.

        The log likelihood ratio at their best amounts (profile likelihood).

        With a block that is `tried` beside them it is what both gain, that one as it was simulated.
        """
        gram, x = self.gram, self._amounts(numbers, tried)
        at = np.concatenate([self.places[i] for i in numbers]) if numbers else np.zeros(0, dtype=int)
        if tried is not None:
            at, x = np.append(at, self.places[tried]), np.append(x, np.ones(len(self.places[tried])))
        return float(-gram[at, 0] @ x - 0.5 * x @ gram[np.ix_(at, at)] @ x)

    def earning(self, numbers: Sequence[int], least: float, tried: int | None = None) -> list[int]:
        """Of some blocks at once, beside one that is `tried`, those that each gain at least so much beside the others:
        without the one that gains least, one after the other (backward elimination).
        """
        kept, beside = list(numbers), [] if tried is None else [tried]
        while kept:
            rest = {k: [i for i in kept if i != k] for k in kept}
            gains = {k: self._gain([*beside, *others]) for k, others in rest.items()}
            spare = max(kept, key=lambda k: gains[k])
            if self._gain([*beside, *kept]) - gains[spare] >= least:
                break
            kept = rest[spare]
        return kept

    def together(self, numbers: Sequence[int], tried: int | None = None) -> list[LinearGain]:
        """Some blocks at once, at their best amounts (beside one that is `tried` as it was simulated); what each gains
        is not told.
        """
        amounts, ends = self._amounts(numbers, tried), np.cumsum([0, *(len(self.places[i]) for i in numbers)])
        return [
            LinearGain(self.blocks[n], tuple(amounts[i:j].tolist()), 0.0)
            for n, (i, j) in zip(numbers, pairwise(ends.tolist()), strict=True)
        ]

    def several(self, least: float) -> list[LinearGain]:
        """Blocks added one after the other (forward selection), and exchanged, as long as each gains at least so much
        beside the others.
        """
        taken: list[int] = []
        while True:
            best = self._best(taken)
            if best is None or best[1] < least:
                break
            taken.append(best[0])
            for i in list(taken[:-1]):  # what the new one made superfluous goes, or gives way
                others = [k for k in taken if k != i]
                other, own = self._best(others), self._gain(taken) - self._gain(others)
                if other is not None and other[0] != i and other[1] > own + 1.0:
                    taken = [*others, other[0]]
                elif own < least:
                    taken = others
            if len(taken) > len(self.blocks) // 2:
                break
        amounts = self._amounts(taken)
        out, at = [], 0
        total = self._gain(taken)
        for i in taken:
            n = len(self.places[i])
            gain = total - self._gain([k for k in taken if k != i])
            out.append(LinearGain(self.blocks[i], tuple(amounts[at : at + n].tolist()), gain))
            at += n
        return out

    def _best(self, taken: Sequence[int]) -> tuple[int, float] | None:
        """The block that gains most beside those that are taken."""
        rough = self._roughly(taken)
        for k in taken:
            rough[self._clashing(k)] = -np.inf
        likely = [int(i) for i in np.argsort(-rough)[:LOOKED] if np.isfinite(rough[i])]
        so_far = self._gain(taken)
        gains = [(i, self._gain([*taken, i]) - so_far) for i in likely]
        return max(gains, key=lambda g: g[1], default=None)

    def _roughly(self, taken: Sequence[int]) -> Array:
        """What every block gains beside those that are taken, one parameter at a time and those that are taken free of
        their bounds. Shape (blocks,).
        """
        gram = self.gram
        if taken:
            at = np.concatenate([self.places[i] for i in taken])
            inner = gram[np.ix_(at, at)] + np.eye(len(at)) / SLAB**2
            gram = gram - gram[:, at] @ np.linalg.solve(inner, gram[at])
        curve, slope = np.maximum(np.diag(gram)[1:], 1e-12), gram[1:, 0]
        x = np.clip(-slope / curve, self.low, self.high)
        gain = -slope * x - 0.5 * curve * x**2 - 0.5 * np.log1p(SLAB**2 * curve)
        return np.array([gain[at - 1].sum() for at in self.places])

    def _clashing(self, number: int) -> Array:
        """The blocks that cannot stand beside one. Shape (k,), of int."""
        if number not in self._clashes:
            suspect = self.blocks[number].suspect
            self._clashes[number] = np.array([i for i, b in enumerate(self.blocks) if clash(suspect, b.suspect)], int)
        return self._clashes[number]

    def _gain(self, numbers: Sequence[int]) -> float:
        """The gain in evidence of some blocks together, at their best amounts within reach: Laplace's approximation."""
        if not numbers:
            return 0.0
        at = np.concatenate([self.places[i] for i in numbers])
        g, b = self.gram[np.ix_(at, at)], self.gram[at, 0]
        x = self._amounts(numbers)
        gain = -float(b @ x) - 0.5 * float(x @ g @ x)
        free = [k for i in numbers for k in self.places[i] if self.blocks[i].start.kind != "whole"]
        if free:
            g = self.gram[np.ix_(free, free)]
            inside = np.isin(at, free)
            gain -= float(np.sum(negative_log_prior(x[inside] / SLAB)))
            gain -= 0.5 * float(np.linalg.slogdet(np.eye(len(free)) + SLAB**2 * g)[1])
        return gain

    def _amounts(self, numbers: Sequence[int], tried: int | None = None) -> Array:
        """The best amounts of some blocks together, within reach: bounded least squares by the Cholesky factor."""
        if not numbers:
            return np.zeros(0)
        at = np.concatenate([self.places[i] for i in numbers])
        low, high = self.low[at - 1], self.high[at - 1]
        g = self.gram[np.ix_(at, at)] + np.diag(self.least[at - 1])
        beside = np.zeros(0, dtype=int) if tried is None else self.places[tried]
        left = self.gram[at, 0] + self.gram[np.ix_(at, beside)].sum(axis=1)
        try:
            x = np.linalg.solve(g, -left)
        except np.linalg.LinAlgError:
            x = np.zeros(len(at))
        if ((x < low) | (x > high)).any():
            factor = np.linalg.cholesky(g + 1e-12 * np.trace(g) * np.eye(len(at)))
            right = np.linalg.solve(factor, -left)
            fixed = low == high
            high = np.where(fixed, high + 1e-9, high)
            x = bounded(factor.T, right, low, high)
        return np.asarray(x)


def linear_at(at: Scored, blocks: Sequence[Block]) -> Linear:
    """The linearised model around a fit, in its own metric."""
    return Linear(at.metric, at.fit.residual, at.fit.slope, blocks)
