"""What speaks against findings once the model is chosen: their own intervals, and held-out runs, which are looked at
once: the difference in log predictive density, with its error.

First of every finding beside all others, then of the whole model beside the scenario's own.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from realitygap.diagnose.data.changes import Change, Suspect
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.fit.fit import Care, Fit
from realitygap.diagnose.fit.motions import residual
from realitygap.diagnose.judge.gaps import held_out_gap
from realitygap.diagnose.likelihood.floors import Floors, measure
from realitygap.diagnose.likelihood.whitening import channels, effective_fraction
from realitygap.diagnose.search.apart import ERRORS, compare
from realitygap.diagnose.search.discrepancy import Discrepancy
from realitygap.diagnose.search.evidence import Scored, score
from realitygap.diagnose.search.found import Found
from realitygap.diagnose.search.prune import untold
from realitygap.diagnose.search.round import DOUBTFUL
from realitygap.robot.drive import Array

NOTHING = 0.1
"""What a model that changes nothing on the held-out runs may seem to lose (odds of 10 : 9), and what one that does
nothing there may seem to gain."""

CHOSE = 10.0
"""How many times as much held-out runs say against a finding as training runs say for it, which chose it. Of 147 names
that are true of machines with nearly right laws, planted at six seeds, none made held-out runs less probable; of 14
others three did, by a sixth to a ninth of what they had gained. On an SO-101 they lost a twelfth of what the profile
of its commands had gained, without which the error on training runs doubles."""

WIDER = 1.2
"""How many times as large the held-out gap may be with a finding as without, the other values fitted anew. The gap is a
mean of squares that counts every sample alike, and moves by some per cent where values do: the gain that an XL330's
friction needs beside it widens the gap by 1 %."""


@dataclass(frozen=True)
class Verdict:
    """How much more probable the chosen model makes what was kept back (natural logarithm), and the standard error."""

    gain: float
    error: float

    @property
    def worse(self) -> bool:
        """Whether held-out runs do not speak for it, beyond what stretches of them scatter by (95 %, one-sided): a name
        has to help where it was not fitted. Of a push that comes and goes was made a constant effort, which they gained
        8 ± 7 by; what is true of 21 other planted machines they gained 1.8 (a velocity's filter) or 3 to 36 errors by.
        """
        return self.least < 0.0

    @property
    def better(self) -> bool:
        """Whether held-out runs do speak for it, by more than what changes nothing there may seem to gain."""
        return self.least > 2.0 * NOTHING

    @property
    def least(self) -> float:
        """What they gain at least (95 %, one-sided)."""
        return self.gain - ERRORS * self.error + NOTHING


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
    nothing = Discrepancy(effective_fraction(watched, after), np.zeros((len(after), 0)))
    apart = compare(watched, *(score(watched, Fit((), r), nothing) for r in (after, before)))
    return Verdict(*apart)


@dataclass(frozen=True)
class Against:
    """What held-out runs say against a finding.

    Attributes:
        verdict: how much more probable it makes them.
        gaps: their gap without and with it, in floors.
        alone: the same as the verdict where all other values stay as they are.
    """

    verdict: Verdict
    gaps: tuple[float, float]
    alone: Verdict

    @property
    def weight(self) -> float:
        """What they say for it at the least, which counts `CHOSE` times where it is against it: what helps by chance
        where it was not fitted may be anything. By each of 127 names that were true of machines planted at six seeds
        held-out runs gained 2.2 to 39 standard errors, beside all others; by four that were false 0.8 to 1.3.
        """
        return min(self.verdict.least, CHOSE * self.verdict.least)

    @property
    def silent(self) -> bool:
        """Whether they say nothing of it, as of a limit that they do not reach: names are shown where none was fitted.
        Of some hundred names that were true of planted machines none did nothing there; a limit did, that was a droop,
        and one that a single stroke of a training run went beyond. What it is worth there other values may take over.
        """
        return abs(self.alone.gain) + self.alone.error <= NOTHING

    @property
    def widens(self) -> bool:
        """Whether the gap that is shown is clearly larger with it, and above the floor."""
        without, with_ = self.gaps
        return with_ > WIDER * max(without, 1.0)


def supported(
    simulations: Simulations, found: Found, keep: Collection[Suspect]
) -> tuple[Found, dict[Suspect, Against]]:
    """What was found without the findings that held-out runs speak against, one after the other, the least first; and
    what they say against each of these. `keep` stays.

    Training and held-out runs together have to say as much for a finding as one has to be worth (`Found.least`), where
    what held-out runs may say against it counts `CHOSE` times; and no finding may widen the gap that is shown, or do
    nothing there. What they speak for beside all that was found stays: without another finding it may seem worse than
    it is.
    """
    against: dict[Suspect, Against] = {}
    asked = set(found.without).difference(keep)
    while True:
        doubted = {}
        for s in asked & set(found.without):
            told = _asked(simulations, found, s)
            if told.widens or told.silent or found.gains[s] + told.weight < found.least[s]:
                doubted[s] = told
        if not doubted and against:
            found = _completed(found, keep)
            return replace(found, cautious=found.criterion.cautious(found.best.fit)), against
        if not doubted:
            return found, against
        least = min(doubted, key=lambda s: doubted[s].verdict.gain)
        against[least] = doubted[least]
        asked = set(doubted) - {least}
        found = _without(simulations, found, least, asked)


def _asked(simulations: Simulations, found: Found, suspect: Suspect) -> Against:
    """What held-out runs say of a finding, beside all others."""
    without, with_ = found.without[suspect].fit.changes, found.best.fit.changes
    gaps = held_out_gap(simulations, found.floors, without), held_out_gap(simulations, found.floors, with_)
    others = [c for c in with_ if c.suspect != suspect]
    verdict, alone = (predicted(simulations, found.floors, with_, beside) for beside in (without, others))
    return Against(verdict, gaps, alone)


def certain_of(simulations: Simulations, found: Found, keep: Collection[Suspect]) -> tuple[Found, list[Suspect]]:
    """What was found without the findings whose 95 % intervals hold what the model has anyway, one after the other, the
    least first; and these. `keep` stays. The intervals of the others are as wide as their values moved by that: what is
    not named may be there.

    Evidence compares models at their best, and intervals say in which range a machine's value is: of 75 findings beside
    nearly right laws, planted at six seeds, six had such an interval, with 9 to 112 in evidence, and none was true.
    """
    vague, gains, whole = list[Suspect](), found.gains, found.best
    sure = sure_of(found)
    while True:
        open_ = untold(simulations.problem, found.cautious, sure).difference(keep, vague)
        if not open_ and not vague:
            return found, vague
        if not open_:
            found = replace(_completed(found, keep), fuller=found.fuller or whole)
            return replace(found, cautious=_wider(found.cautious, whole.fit)), vague
        least = min(open_, key=lambda s: gains.get(s, 0.0))
        vague.append(least)
        found = _without(simulations, found, least, [])
        found = replace(found, cautious=found.criterion.cautious(found.best.fit))


def sure_of(found: Found) -> set[Suspect]:
    """The findings that evidence speaks for by much more than a name needs."""
    return {s for s, least in found.least.items() if found.gains.get(s, 0.0) >= DOUBTFUL * least}


def _wider(cautious: Scored, before: Fit) -> Scored:
    """A model for intervals whose values may be off by what they were elsewhere in another fit, too."""
    away = np.zeros(len(cautious.fit.names)) if cautious.away is None else cautious.away
    return replace(cautious, away=np.hypot(away, moved(cautious.fit, before)))


def moved(fit: Fit, before: Fit) -> Array:
    """How far a fit's values are from where they were in another, in sizes; 0 of what that had not. Shape (p,)."""
    known = {
        (before.changes[i].suspect, name): value for (i, name), value in zip(before.names, before.value, strict=True)
    }
    was = [known.get((fit.changes[i].suspect, n), v) for (i, n), v in zip(fit.names, fit.value, strict=True)]
    return np.asarray((fit.value - np.array(was)) / fit.size)


def as_wide(adjusted: Scored, named: Scored) -> Scored:
    """A model for intervals that are as wide as those of the model before, and as its values moved from there: another
    law may be what is off, so that no value is known better than where nothing is adjusted. Beside a gain that is no
    constant, which friction that is uneven had been taken for, four of four of a Stribeck friction missed the truth.
    """
    fit, before = adjusted.fit, named.fit
    known = {(before.changes[i].suspect, n): off for (i, n), off in zip(before.names, named.deviation, strict=True)}
    was = np.array([known.get((fit.changes[i].suspect, n), 0.0) for i, n in fit.names])
    lacking = (was / fit.size) ** 2 - np.diag(adjusted.covariance)
    away = np.zeros(len(was)) if adjusted.away is None else adjusted.away
    return replace(adjusted, away=np.sqrt(np.maximum(away**2, lacking) + moved(fit, before) ** 2))


def _without(simulations: Simulations, found: Found, suspect: Suspect, asked: Collection[Suspect]) -> Found:
    """The best model without one finding, and without each of the others besides that are `asked`."""
    known = found.without.get(suspect)
    near = found.best.fit if known is None else known.fit
    rest = [c for c in near.changes if c.suspect != suspect]
    best = found.criterion.fit(rest, near) or known or found.criterion.fit(rest, near, "quick")
    if best is None:
        raise RuntimeError(f"the model without {suspect} cannot be simulated")
    found = replace(found, best=best, floors=measure(simulations, best.fit.changes), gains={}, without={})
    return besides(found, asked, "compared")


def _completed(found: Found, keep: Collection[Suspect]) -> Found:
    """What was found without what was dropped, also without each finding that was not asked again."""
    others = {c.suspect for c in found.best.fit.changes}.difference(keep, found.without)
    found = besides(found, others, "quick")
    rivals = {s: rivals for s, rivals in found.rivals.items() if s in found.without}
    return replace(found, rivals=rivals)


def besides(found: Found, asked: Collection[Suspect], care: Care) -> Found:
    """The same with the best model fitted without each finding that is asked as well."""
    best, without = found.best, dict(found.without)
    for change in best.fit.changes:
        if change.suspect in asked:
            rest = [c for c in best.fit.changes if c is not change]
            other = found.criterion.fit(rest, best.fit, care)
            if other is not None:
                without[change.suspect] = other
    gains = {s: best.evidence - other.evidence for s, other in without.items()}
    return replace(found, gains=gains, without=without)
