"""Law discrepancy on motions that are not recorded yet, as a diagnosis would count with it."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from realitygap.diagnose.candidates.starts import starts
from realitygap.diagnose.data.changes import Suspect, stands_beside
from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.fit.fit import Fit, slope
from realitygap.diagnose.fit.motions import Motions
from realitygap.diagnose.fit.responses import Block, respond, single
from realitygap.diagnose.fit.space import Space
from realitygap.diagnose.likelihood.channel_blocks import ChannelBlocks
from realitygap.diagnose.likelihood.floors import Floors
from realitygap.diagnose.likelihood.metric import marginalised
from realitygap.diagnose.likelihood.whitening import Channel, Whitening, channels
from realitygap.diagnose.search.discrepancy import Discrepancy, law_discrepancy
from realitygap.diagnose.search.evidence import Scored
from realitygap.robot.drive import Array


@dataclass(frozen=True)
class PredictedDiscrepancy:
    """What laws may be off by, on training cases and motions.

    Attributes:
        problem: with the motions.
        found: the channels of what is stacked: training cases, then motions.
        fits: every explanation, with residual and slopes of all of these.
        blocks: responses of what could be added to the named model.
        whitening: of the named model's recordings.
    """

    problem: Problem
    found: tuple[Channel, ...]
    fits: tuple[Fit, ...]
    blocks: tuple[Block, ...]
    whitening: Whitening

    @cached_property
    def named(self) -> Discrepancy:
        """At the named model."""
        return self._told(0, {c.case for c in self.found})

    @property
    def before(self) -> Array:
        """The responses at the named model on training cases. Shape (m₀, q)."""
        return self.named.responses[self._of(self.problem.of("train"))]

    @property
    def ahead(self) -> Array:
        """The responses at the named model on motions. Shape (m, q)."""
        return self.named.responses[~self._of(self.problem.of("train"))]

    def at(self, number: int, case: int) -> Discrepancy:
        """At an explanation, on training cases and one motion."""
        return self._told(number, {*self.problem.of("train"), case})

    def _told(self, number: int, cases: Collection[int]) -> Discrepancy:
        rows, fit = self._of(cases), self.fits[number]
        fit = replace(fit, residual=fit.residual[rows], slope=fit.slope[rows])
        here = [c.suspect for c in fit.changes]
        beside = [b for b in self.blocks if stands_beside(b.suspect, here)]
        found = tuple(c for c in self.found if c.case in cases)
        whitening = self.whitening.elsewhere(found)
        none = ChannelBlocks.of(np.zeros((len(whitening.rows), 0)), whitening.number)
        metric = marginalised(whitening, np.ones(len(fit.residual)), none, 0.0)
        return law_discrepancy(self.problem, fit, [replace(b, columns=b.columns[rows]) for b in beside], metric)

    def _of(self, cases: Collection[int]) -> NDArray[np.bool_]:
        """Which stacked samples are those of some cases. Shape (m,)."""
        return np.concatenate([np.full(len(c.time), c.case in cases) for c in self.found])


def predicted_discrepancy(
    simulations: Simulations,
    explanations: Sequence[Scored],
    everyone: Sequence[Suspect],
    cases: Sequence[int],
    floors: Floors,
) -> PredictedDiscrepancy | None:
    """What laws may be off by, on training cases and motions; None where an explanation cannot be simulated.

    Args:
        simulations: of the problem with the motions.
        explanations: the models, the named one first.
        everyone: the suspects that count: those at single targets that follow a straight line.
        cases: the motions.
        floors: of all cases.
    """
    problem = simulations.problem
    both = [*problem.of("train"), *cases]
    found = tuple(channels(problem, floors, both))
    named = explanations[0]
    motions = Motions(simulations, both, floors.coarse)
    fits = [_everywhere(motions, e.fit) for e in explanations]
    good = tuple(f for f in fits if f is not None)
    if len(good) < len(fits):
        return None
    accepted = [c.suspect for c in named.fit.changes]
    alone = [s for s in everyone if s.kind.sits_at != "joint" or single(s)]
    possible = [s for s in alone if stands_beside(s, accepted)]
    tried = [start for s in possible for start in starts(problem, s) if start.kind == "linear"]
    blocks = respond(motions, named.fit.changes, tried, found)
    return PredictedDiscrepancy(problem, found, good, tuple(blocks), named.metric.whitening)


def _everywhere(motions: Motions, fit: Fit) -> Fit | None:
    """A fit with residual and slopes of these motions."""
    (now,) = motions.residuals([fit.changes])
    if now is None:
        return None
    space = Space(motions.problem, fit.changes)
    there = slope(motions, space, space.first)
    return replace(fit, residual=now, slope=there * (fit.size / space.scale if len(space.scale) else 1.0))
