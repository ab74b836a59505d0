"""The search: from the scenario's model to the one with the best evidence, by adding, exchanging and dropping.

Stepwise model selection by evidence, with a penalty for the number of suspects (`needed`).

Where the effort was measured it begins at what that says along the measured motion: inverse dynamics takes a tenth of
the time of a simulation, in which no error adds up, and no servo hides what its joint lacks.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from realitygap.diagnose.candidates.suspects import plain_first, suspects
from realitygap.diagnose.data.along import along_the_motion
from realitygap.diagnose.data.changes import Change, ModelKey, Suspect, model_key, stands_beside
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.fit.demanded import demanded
from realitygap.diagnose.fit.fit import Fit
from realitygap.diagnose.fit.responses import Block, at_once
from realitygap.diagnose.likelihood.floors import measure
from realitygap.diagnose.search.ahead import by_two_steps
from realitygap.diagnose.search.criterion import Criterion
from realitygap.diagnose.search.evidence import Scored
from realitygap.diagnose.search.exchange import Exchanged, exchanged, renamed
from realitygap.diagnose.search.found import Found
from realitygap.diagnose.search.grow import SURE, Ways, grown, shared
from realitygap.diagnose.search.merged import merged
from realitygap.diagnose.search.one_for_two import one_for_two
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
    walk = _Walk(simulations, everyone, told, say, budget)
    for _ in range(ROUNDS):
        if not walk.goes_on():
            break
    return walk.found()


class _Walk:
    """The walk of a search from model to model: where it stands, and what it remembers of where it has been.

    In every round it adds what gains enough. Where nothing does, it exchanges and drops; where that is no better
    either, it tries an unnamed effort, and two steps at once.

    Attributes:
        keep: what the recordings show by themselves, which stays.
        round: the round that it is in.
        following: the model that was found in it, where the next one stands; None where nothing is better.
        seen: models beside which everything has been tried: what was dropped there would only be added again.
        plain: models that a plainer name led to.
        failed: moves that gained too little.
        again: whether these are tried once more, beside what is new.
        asked: findings that were asked whether they have the right name.
        last: what could be left out or exchanged, when that was last asked; nothing since something was added.
        fuller: the model from which findings were left out since; None where none was.
        dropped: whether the last move left something out.
        cut: whether the search is ended while it may have found more.
    """

    def __init__(
        self,
        simulations: Simulations,
        everyone: Sequence[Suspect],
        told: Sequence[Change],
        say: Say,
        budget: SearchBudget,
    ) -> None:
        self.simulations, self.everyone, self.say, self.budget = simulations, everyone, say, budget
        self.limit, self.keep = needed(len(everyone)), [c.suspect for c in told]
        self.many = at_once(simulations.problem)  # of few joints all is looked at anew after every move
        self.nothing = Fit(tuple(told), demanded(simulations, told, simulations.problem.of("train")))
        self.at = _along(simulations, self.nothing, everyone, self.limit, say, budget)
        self.looked_at = plain_first(simulations.problem, everyone)
        self.round, self.first = self._round(), True
        self.following: Scored | None = None
        self.seen, self.plain, self.failed = set[ModelKey](), set[ModelKey](), set[ModelKey]()
        self.again, self.dropped, self.cut = True, False, False
        self.asked, self.last = set(self.keep), Exchanged()
        self.fuller: Scored | None = None

    def goes_on(self) -> bool:
        """One round, and whether it found something better."""
        if not self.first and not self._stays():
            self.round = self._round(self.round.blocks if self.round.last else ())  # what is tried promised most before
        round_, began, explained = self.round, self.simulations.steps, self.round.explained
        whole = self._whole
        self.following = following = self._better()
        if following is None:
            return False
        if not self.first:
            gained = following.evidence - round_.now.evidence
            self.budget = round_.budget.beside(self.simulations.steps - began, gained, explained)
            round_.budget = self.budget
        self.say("; ".join(told_change(c) for c in following.fit.changes))
        if self.many and not self.dropped:
            self.following = following = _further(round_, following, self.keep, self.failed)
        anew = self.dropped or (self.first and not whole)
        self.at, self.looked_at = following.fit, list(self.everyone) if anew else round_.likely(LIKELY)
        self.first = False
        return True

    def found(self) -> Found:
        """What was found, where it goes on no more."""
        round_, last = self.round, self.last
        start = round_.criterion.score(self.nothing)
        best = round_.criterion.seen(round_.retold())
        named = [c.suspect for c in best.fit.changes]
        left = {s: round_.leaves(best, {s.kind.law}, last.without.get(s, start)) for s in named}
        return Found(
            base=start,
            best=best,
            cautious=round_.criterion.cautious(best.fit),
            limit=self.limit,
            least={s: max(self.limit, little) for s, little in left.items()},
            floors=measure(self.simulations, best.fit.changes),
            criterion=round_.criterion,
            gains=last.gains,
            without=last.without,
            rivals=last.rivals,
            candidates=round_.candidates,
            short=round_.short,
            beaten=round_.beaten,
            cut=self.cut,
            blocks=round_.blocks,
            fuller=self.fuller,
        )

    def _round(self, known: Sequence[Block] = ()) -> Round:
        """A new round at the model that was found, with the responses that are known of one near by."""
        return Round(self.simulations, self.at, self.looked_at, self.limit, self.nothing, self.say, self.budget, known)

    def _stays(self) -> bool:
        """Whether the round goes on at what was found in it, as it knows most of what is there: of many joints."""
        if not self.many or self.following is None or not (self.dropped or self.round.late):
            return False
        return self.round.moved(self.following)

    @property
    def _over(self) -> bool:
        """Whether nothing more is looked for: it is late, and this is not the first round, which is always made."""
        return self.round.late and not self.first

    @property
    def _whole(self) -> bool:
        """Whether the round looks at all suspects."""
        return len(self.round.everyone) == len(self.everyone)

    def _better(self) -> Scored | None:
        """The model that the round leads to: one with more in it, else with another name or less, else with an unnamed
        effort or two steps at once.
        """
        following = self._added()
        self.again, self.dropped, self.cut = following is not None, False, self._over
        if following is not None:
            self.last, self.fuller = Exchanged(), None  # beside what is new, another name may be as good
            return following
        following = self._exchanged()
        if following is None and not self._over:
            following = with_unnamed(self.round, self.keep) or by_two_steps(self.round, self.keep, self.seen)
            self.again = following is not None
        return following

    def _added(self) -> Scored | None:
        """The model with more in it, of what the round looks at, of all suspects, and of what tells the same in another
        way. None where nothing gains enough.
        """
        round_, here = self.round, model_key(self.round.now.fit.changes)
        fresh = here not in self.seen
        following = self._grown(self._whole and self.again) if fresh and not self._over else None
        if following is not None and not self.many:
            following = self._named(following)
        if following is None and not self._whole and not self._over:
            round_.widened(self.everyone)
            following = self._grown(self.again) if fresh else None
        for ways in (parted, shared, merged, one_for_two):
            if following is None and fresh and not self._over:
                following = self._grown(self.again, ways(round_))
        self.seen.add(here)
        return following

    def _grown(self, again: bool, ways: Ways | None = None) -> Scored | None:
        return grown(self.round, self.keep, self.failed, again, ways)

    def _named(self, following: Scored) -> Scored:
        """A model with more in it, or the accepted one with a better name for what was found last, where it has one."""
        better = _renamed(self.round, self.keep, self.asked)
        if better is None or model_key(better.fit.changes) in self.seen or _richer(self.round, following, better):
            return following
        return better

    def _exchanged(self) -> Scored | None:
        """The model with a better name for a finding, or without what is not needed; None where there is no better one.

        It goes back to a model where it stood before only if that has less in it, or by a plainer name, once.
        """
        self.last = exchanged(self.round, self.keep, self.last)
        following = self.last.better
        if following is not None:
            there = model_key(following.fit.changes)
            self.dropped = len(following.fit.changes) < len(self.round.now.fit.changes)
            plainer = self.last.plainer and there not in self.plain
            if there in self.seen and not self.dropped and not plainer:
                following = None
            elif self.last.plainer:
                self.plain.add(there)
        if following is None or self.dropped:
            self.fuller = self.fuller or self.last.fuller
        else:
            self.fuller = None
        return following


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
    new = [c for c in named if stands_beside(c.suspect, [t.suspect for t in nothing.changes])]
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
