"""Held-out runs, looked at once after the model is chosen: the difference in log predictive density, with its error."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from realitygap.diagnose.data.changes import Change
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.fit.fit import Fit
from realitygap.diagnose.fit.responses import residual
from realitygap.diagnose.likelihood.floors import Floors
from realitygap.diagnose.likelihood.whitening import channels, facts
from realitygap.diagnose.search.evidence import score
from realitygap.diagnose.search.exchange import Rival, compare
from realitygap.diagnose.search.imperfections import Imperfections

NOTHING = 0.1
"""What a model that changes nothing on the held-out runs may seem to lose (odds of 10 : 9)."""


@dataclass(frozen=True)
class Verdict:
    """How much more probable the chosen model makes what was kept back (natural logarithm), and the standard error."""

    gain: float
    error: float

    @property
    def worse(self) -> bool:
        """Whether the chosen model predicts no better than the scenario's own: a name has to help where it was not
        fitted.
        """
        return self.gain < -NOTHING


def predicted(simulations: Simulations, floors: Floors, changes: Sequence[Change]) -> Verdict:
    """The difference in log predictive density on the held-out runs: with the changes, less without."""
    judge = simulations.problem.of("held_out")
    watched = channels(simulations.problem, floors, judge)
    both = [residual(simulations, c, judge) for c in ([], changes)]
    if both[1] is None:
        return Verdict(-np.inf, 0.0)
    if both[0] is None:
        return Verdict(np.inf, 0.0)
    none = np.zeros((len(both[1]), 0))
    nothing = Imperfections(facts(watched, both[1]), none)
    before, after = (score(watched, Fit((), r), nothing) for r in both if r is not None)
    apart: Rival | None = None
    if changes:
        apart = compare(watched, after, before, changes[0].suspect)
    return Verdict(0.0, 0.0) if apart is None else Verdict(apart.behind, apart.error)
