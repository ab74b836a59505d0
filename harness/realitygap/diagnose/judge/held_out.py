"""Held-out runs, looked at once after the model is chosen: the difference in log predictive density, with its error.

First of every finding beside all others, then of the whole model beside the scenario's own.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from realitygap.diagnose.data.changes import Change, Suspect
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.fit.fit import Care, Fit
from realitygap.diagnose.fit.responses import residual
from realitygap.diagnose.likelihood.floors import Floors, measure
from realitygap.diagnose.likelihood.whitening import channels, facts
from realitygap.diagnose.search.apart import ERRORS, compare
from realitygap.diagnose.search.evidence import score
from realitygap.diagnose.search.exchange import ODDS
from realitygap.diagnose.search.imperfections import Imperfections
from realitygap.diagnose.search.search import Found

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


def predicted(
    simulations: Simulations, floors: Floors, changes: Sequence[Change], beside: Sequence[Change] = ()
) -> Verdict:
    """The difference in log predictive density on the held-out runs: with the changes, less with those `beside`."""
    judge = simulations.problem.of("held_out")
    watched = channels(simulations.problem, floors, judge)
    before, after = (residual(simulations, c, judge) for c in (beside, changes))
    if after is None:
        return Verdict(-np.inf, 0.0)
    if before is None:
        return Verdict(np.inf, 0.0)
    if tuple(changes) == tuple(beside):
        return Verdict(0.0, 0.0)
    nothing = Imperfections(facts(watched, after), np.zeros((len(after), 0)))
    apart = compare(watched, *(score(watched, Fit((), r), nothing) for r in (after, before)))
    return Verdict(*apart)


def supported(simulations: Simulations, found: Found, keep: Collection[Suspect]) -> tuple[Found, dict[Suspect, float]]:
    """What was found without the findings that held-out runs speak against, one after the other, the least first; and
    what held-out runs gain by each of these. `keep` stays.

    They speak against one that makes them less probable by more than a rival may be behind that cannot be told apart:
    what mends training runs so is not their cause. And training and held-out runs together have to say as much for a
    finding as one has to be worth (`Found.least`). What they speak for beside all that was found stays: without another
    finding it may seem worse than it is.
    """
    against: dict[Suspect, float] = {}
    asked = set(found.without).difference(keep)
    while True:
        verdicts = {
            s: predicted(simulations, found.floors, found.best.fit.changes, found.without[s].fit.changes)
            for s in asked & set(found.without)
        }
        doubted = {
            s: v.gain
            for s, v in verdicts.items()
            if -v.gain > max(ODDS, ERRORS * v.error) or found.gains[s] + v.gain < found.least
        }
        if not doubted:
            return (_completed(found, keep) if against else found), against
        least = min(doubted, key=lambda s: doubted[s])
        against[least] = doubted[least]
        asked = set(doubted) - {least}
        found = _without(simulations, found, least, asked)


def _without(simulations: Simulations, found: Found, suspect: Suspect, asked: Collection[Suspect]) -> Found:
    """The best model without one finding, and without each of the others besides that are `asked`."""
    quick = found.without[suspect].fit
    best = found.yardstick.fit(quick.changes, quick) or found.without[suspect]
    found = replace(found, best=best, floors=measure(simulations, best.fit.changes), gains={}, without={})
    return _besides(found, asked, "compared")


def _completed(found: Found, keep: Collection[Suspect]) -> Found:
    """What was found without what was dropped: with intervals, and without each finding that was not asked again."""
    others = {c.suspect for c in found.best.fit.changes}.difference(keep, found.without)
    found = _besides(found, others, "quick")
    rivals = {s: rivals for s, rivals in found.rivals.items() if s in found.without}
    return replace(found, cautious=found.yardstick.cautious(found.best.fit), rivals=rivals)


def _besides(found: Found, asked: Collection[Suspect], care: Care) -> Found:
    """The same with the best model fitted without each finding that is asked as well."""
    best, without = found.best, dict(found.without)
    for change in best.fit.changes:
        if change.suspect in asked:
            rest = [c for c in best.fit.changes if c is not change]
            other = found.yardstick.fit(rest, best.fit, care)
            if other is not None:
                without[change.suspect] = other
    gains = {s: best.evidence - other.evidence for s, other in without.items()}
    return replace(found, gains=gains, without=without)
