"""Law discrepancy on motions that are not recorded yet: the imperfections that a diagnosis would count with."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from realitygap.diagnose.candidates.starts import starts
from realitygap.diagnose.data.changes import Suspect, clash
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.fit.fit import slope
from realitygap.diagnose.fit.responses import residuals, respond, single
from realitygap.diagnose.fit.space import Space
from realitygap.diagnose.likelihood.floors import Floors
from realitygap.diagnose.likelihood.metric import marginalised
from realitygap.diagnose.likelihood.whitening import channels
from realitygap.diagnose.search.evidence import Scored
from realitygap.diagnose.search.imperfections import Imperfections, imperfections
from realitygap.robot.drive import Array


@dataclass(frozen=True)
class Wrong:
    """What laws may be off by.

    Attributes:
        told: what is off, by how much, on training cases and motions.
        rows: how many of the stacked samples are of training cases.
    """

    told: Imperfections
    rows: int

    @property
    def before(self) -> Array:
        """The responses on training cases. Shape (m₀, q)."""
        return self.told.responses[: self.rows]

    @property
    def ahead(self) -> Array:
        """The responses on motions. Shape (m, q)."""
        return self.told.responses[self.rows :]


def wrong(
    simulations: Simulations, named: Scored, everyone: Sequence[Suspect], cases: Sequence[int], floors: Floors
) -> Wrong | None:
    """What laws may be imperfect by at a named model, on training cases and motions; None where it cannot be simulated.

    Args:
        simulations: of the problem with the motions.
        named: the model.
        everyone: the suspects that count: those at single targets that follow a straight line.
        cases: the motions.
        floors: of all cases.
    """
    problem = simulations.problem
    train = problem.of("train")
    both = [*train, *cases]
    found = channels(problem, floors, both)
    fit = named.fit
    (now,) = residuals(simulations, [fit.changes], both, floors.coarse)
    if now is None:
        return None
    space = Space(problem, fit.changes)
    there = slope(simulations, space, space.first, both, floors.coarse)
    there = there * (fit.size / space.scale if len(space.scale) else 1.0)
    accepted = [c.suspect for c in fit.changes]
    alone = [s for s in everyone if s.kind.sits_at != "joint" or single(s)]
    possible = [s for s in alone if not any(clash(s, a) for a in accepted)]
    tried = [start for s in possible for start in starts(problem, s) if start.kind == "linear"]
    blocks = respond(simulations, fit.changes, tried, both, floors.coarse, found)
    whitening = named.metric.whitening.elsewhere(found)
    metric = marginalised(whitening, np.ones(len(now)), np.zeros((len(whitening.rows), 0)), 0.0)
    told = imperfections(problem, replace(fit, residual=now, slope=there), blocks, metric)
    rows = sum(len(c.time) for c in found if c.case in train)
    return Wrong(told, rows)
