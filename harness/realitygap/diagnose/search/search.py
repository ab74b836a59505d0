"""The search: from the scenario's model to the one with the best evidence, by adding, exchanging and dropping.

Stepwise model selection by evidence, with a penalty for the number of suspects (`needed`).

Where the effort was measured it begins at what that says along the measured motion: inverse dynamics takes a tenth of
the time of a simulation, in which no error adds up, and no servo hides what its joint lacks.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from realitygap.diagnose.candidates.suspects import plain_first, suspects
from realitygap.diagnose.data.along import along_the_motion
from realitygap.diagnose.data.changes import Change, ModelKey, Suspect, clash, model_key
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.fit.demanded import demanded
from realitygap.diagnose.fit.fit import Fit
from realitygap.diagnose.fit.responses import Block, at_once
from realitygap.diagnose.likelihood.floors import Floors, measure
from realitygap.diagnose.search.ahead import by_two_steps
from realitygap.diagnose.search.criterion import Criterion
from realitygap.diagnose.search.evidence import Scored
from realitygap.diagnose.search.exchange import Exchanged, exchanged, renamed
from realitygap.diagnose.search.grow import SURE, grown, shared
from realitygap.diagnose.search.linear import LinearGain
from realitygap.diagnose.search.merged import merged
from realitygap.diagnose.search.one_for_two import one_for_two
from realitygap.diagnose.search.rivals import Rival
from realitygap.diagnose.search.rotor import parted
from realitygap.diagnose.search.round import Round, Say, told_change
from realitygap.diagnose.search.unnamed import with_unnamed
from realitygap.diagnose.search_budget import UNLIMITED, SearchBudget
from realitygap.files.errors import InputError

LIKELY = 80
"""Suspects that a round looks at again: those that promised most in the one before; all, where none of them helps."""
AHEAD = 1 / 3
"""The most of the time that goes into where to begin: on a slow machine simulations have the rest."""
ROUNDS = 30
"""Rounds at most: more findings than this no page could show."""


@dataclass
class Found:
    """What a search found.

    Attributes:
        base: the scenario's own model, by the criterion of the last round.
        best: the model with the best evidence.
        cautious: the same, for intervals.
        limit: what a finding has to gain.
        least: the same for each, or what laws of its kind leave of what the best model explains, where that is more.
        floors: of the best model.
        criterion: by which models were compared in the last round.
        gains: evidence that is lost without each finding, by suspect.
        without: the model without each finding, its other values fitted anew.
        rivals: what could stand in the place of each finding, the closest first.
        candidates: what was closest and not taken, best first.
        short: what it gains where it was fitted, and what it would have to gain.
        beaten: findings in whose place an unnamed effort gains what a name has to, though it is none itself.
        cut: whether the search was ended while it may have found more.
        blocks: the responses of what could still be added, in the last round.
        fuller: the model from which findings were left out in the end, as they gain too little; None where none was.
        adjusted: what of the best model is no finding, but what its laws are off by (`judge.adjust`).
    """

    base: Scored
    best: Scored
    cautious: Scored
    limit: float
    least: Mapping[Suspect, float]
    floors: Floors
    criterion: Criterion
    gains: dict[Suspect, float] = field(default_factory=dict)
    without: dict[Suspect, Scored] = field(default_factory=dict)
    rivals: dict[Suspect, list[Rival]] = field(default_factory=dict)
    candidates: list[LinearGain] = field(default_factory=list)
    short: Mapping[Suspect, tuple[float, float]] = field(default_factory=dict)
    beaten: Collection[Suspect] = ()
    cut: bool = False
    blocks: Sequence[Block] = ()
    fuller: Scored | None = None
    adjusted: tuple[Suspect, ...] = ()


def search(
    simulations: Simulations,
    everyone: Sequence[Suspect],
    told: Sequence[Change],
    say: Say,
    budget: SearchBudget = UNLIMITED,
) -> Found:
    """Search until no move gains enough.

    Args:
        simulations: of the problem.
        everyone: the suspects.
        told: changes that the recordings show by themselves; they stay.
        say: told what is being done.
        budget: how long to look for more: the first round ends with what gains enough, and what was found by then is
            still asked whether it is needed, and what could stand in its place, which is told.

    Raises:
        InputError: for a scenario whose own model cannot be simulated.
    """
    limit, kept = needed(len(everyone)), [c.suspect for c in told]
    nothing = Fit(tuple(told), demanded(simulations, told, simulations.problem.of("train")))
    at = _along(simulations, nothing, everyone, limit, say, budget)
    seen, plain, again = set[ModelKey](), set[ModelKey](), True
    asked = set(kept)  # whether they have the right name
    looked_at, last, failed = plain_first(simulations.problem, everyone), Exchanged(), set[ModelKey]()
    round_, following, dropped = Round(simulations, at, looked_at, limit, nothing, say, budget), None, False
    fuller: Scored | None = None
    many, cut = at_once(simulations.problem), False  # of few joints all is looked at anew after every move
    for number in range(ROUNDS):
        stays = many and following is not None and (dropped or round_.late) and round_.moved(following)
        if number > 0 and not stays:
            known = round_.blocks if round_.last else ()  # what is tried now promised most before
            round_ = Round(simulations, at, looked_at, limit, nothing, say, budget, known)
        began, explained = simulations.steps, round_.explained
        here, whole = model_key(round_.now.fit.changes), len(round_.everyone) == len(everyone)
        first, fresh = number == 0, here not in seen  # what was dropped here once would only be added again
        following = grown(round_, kept, failed, whole and again) if fresh and not _over(round_, first) else None
        if following is not None and not many:
            better = _renamed(round_, kept, asked)
            if better is not None and model_key(better.fit.changes) not in seen:
                following = following if _richer(round_, following, better) else better
        if following is None and not whole and not _over(round_, first):
            round_.widened(everyone)
            following = grown(round_, kept, failed, again) if fresh else None
        for ways in (parted, shared, merged, one_for_two):
            if following is None and fresh and not _over(round_, first):
                following = grown(round_, kept, failed, again, ways(round_))
        seen.add(here)
        again = following is not None  # what failed is tried again beside what is new
        dropped, cut = False, _over(round_, first)
        if following is not None:
            last, fuller = Exchanged(), None  # beside what is new, another name may be as good
        else:
            last = exchanged(round_, kept, last)
            following = last.better
            fewer = following is not None and len(following.fit.changes) < len(round_.now.fit.changes)
            there = None if following is None else model_key(following.fit.changes)
            if there in seen and not fewer and not (last.plainer and there not in plain):
                following = None
            elif there is not None and last.plainer:  # a plain name that led to one which says no more is gone back to
                plain.add(there)
            dropped = following is not None and fewer
            fuller = None if following is not None and not fewer else fuller or last.fuller
        if following is None and not _over(round_, first):
            following = with_unnamed(round_, kept) or by_two_steps(round_, kept, seen)
            again = following is not None
        if following is None:
            break
        if not first:
            gained = following.evidence - round_.now.evidence
            round_.budget = budget = round_.budget.beside(simulations.steps - began, gained, explained)
        say("; ".join(told_change(c) for c in following.fit.changes))
        if many and not dropped:
            following = _further(round_, following, kept, failed)
        at, looked_at = following.fit, list(everyone) if dropped or (first and not whole) else round_.likely(LIKELY)
    start = round_.criterion.score(nothing)
    best = round_.retold()
    best = round_.criterion.seen(best)
    floors = measure(simulations, best.fit.changes)
    cautious = round_.criterion.cautious(best.fit)
    named = [c.suspect for c in best.fit.changes]
    return Found(
        base=start,
        best=best,
        cautious=cautious,
        limit=limit,
        least={s: max(limit, round_.leaves(best, {s.kind.law}, last.without.get(s, start))) for s in named},
        floors=floors,
        criterion=round_.criterion,
        gains=last.gains,
        without=last.without,
        rivals=last.rivals,
        candidates=round_.candidates,
        short=round_.short,
        beaten=round_.beaten,
        cut=cut,
        blocks=round_.blocks,
        fuller=fuller,
    )


def _along(
    simulations: Simulations, nothing: Fit, everyone: Sequence[Suspect], limit: float, say: Say, budget: SearchBudget
) -> Fit:
    """Where to begin: at what explains the measured effort along the measured motion, where that helps a simulation as
    well, and else at the scenario's own model. What is not needed there is dropped as anything else.
    """
    measured, allowed = along_the_motion(simulations.problem), set(everyone)
    both = [] if measured is None else [s for s in suspects(measured) if s in allowed]
    if measured is None or not both:
        return nothing
    ordinary = SearchBudget.of(int(measured.judged.sum()), None, 0.0)
    say("along the measured motion")
    with Simulations(measured, workers=1) as following:
        try:
            found = search(following, both, (), say, budget.part(AHEAD, ordinary.steps))
        except InputError:  # what is followed cannot be told, and what is driven can
            return nothing
    named = [c for c in found.best.fit.changes if c.suspect.table is None]
    new = [c for c in named if not any(clash(c.suspect, t.suspect) for t in nothing.changes)]
    criterion = Criterion(simulations, nothing.changes)
    criterion.set_effective_fraction(nothing.residual)
    there = criterion.fit([*nothing.changes, *new], care="compared") if new else None
    if there is None or there.evidence - criterion.score(nothing).evidence < limit * len(new):
        return nothing
    say("; ".join(told_change(c) for c in there.fit.changes))
    return there.fit


def _renamed(round_: Round, keep: Sequence[Suspect], asked: set[Suspect]) -> Scored | None:
    """The model with a better name for one of the findings that were not asked for theirs, which they are now."""
    new = [c.suspect for c in round_.now.fit.changes if c.suspect not in asked]
    better = renamed(round_, keep, new) if new else None
    asked.update(new if better is None else [*new, *(c.suspect for c in better.fit.changes)])
    return better


def _richer(round_: Round, found: Scored, renamed: Scored) -> bool:
    """Whether all that is new in a model is a shape of what is there, and it gains more than another name does.

    A profile that gained 1624 by its acceleration was left without it for another name of a friction, which gained 76.
    """
    same = {c.suspect for c in found.fit.changes} == {c.suspect for c in round_.now.fit.changes}
    return same and found.evidence > renamed.evidence


def _over(round_: Round, first: bool) -> bool:
    """Whether nothing more is looked for: it is late, and this is not the first round, which is always made."""
    return round_.late and not first


def _further(round_: Round, found: Scored, keep: Sequence[Suspect], failed: set[ModelKey]) -> Scored:
    """What more gains enough beside what was found in a round, with what it knows: the next one looks at all anew."""
    following: Scored | None = found
    while following is not None and not round_.late and round_.moved(following):
        found, following = following, grown(round_, keep, failed, again=False)
        if following is not None:
            round_.say("  and " + "; ".join(told_change(c) for c in following.fit.changes))
    return found if following is None else following


def needed(suspects: int) -> float:
    """The gain in evidence that a name needs among so many suspects.

    The logarithm of their number, as in the extended BIC (Chen & Chen 2008, γ = 1), and odds of 20 to 1.
    """
    return float(np.log(max(suspects, 1))) + SURE
