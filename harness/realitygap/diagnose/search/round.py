"""One round of the search: where it stands, and what everything that could be added would gain there."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import replace

import numpy as np

from realitygap.diagnose.candidates.starts import Start
from realitygap.diagnose.candidates.suspects import everyday
from realitygap.diagnose.data.changes import Change, Suspect, as_read, stands_beside
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.fit.demanded import demanded
from realitygap.diagnose.fit.fit import Fit
from realitygap.diagnose.fit.responses import Block, at_once, single
from realitygap.diagnose.search.apart import ERRORS, compare, reached
from realitygap.diagnose.search.criterion import Criterion
from realitygap.diagnose.search.discrepancy import SHARE, WORST, known_to
from realitygap.diagnose.search.evidence import DISCREPANCY_SCALES, Scored, stretches
from realitygap.diagnose.search.linear import LinearGain, linear_at
from realitygap.diagnose.search_budget import UNLIMITED, SearchBudget
from realitygap.robot.drive import Array

BEAM = 4
"""Tries far from linear that are kept: those of most predicted gain."""
GLANCED = 64
"""Tries of which that is asked: those that come closest in the metric that there is. A humanoid has 700."""
DEEP = 14
"""Suspects that are simulated at the amount that fits best in the linearised model: those of most linear gain, if any.
That predicts too little of what leaves less unexplained (1.7 of 18, for half of an ordinary constant effort)."""
FOLLOWED = (0.5, 1.0, 2.0)
"""What that amount is multiplied by: the linearised model may lead too far, or end too early."""

DOUBTFUL = 2.0
"""A finding that gains less than this many times what a name needs is doubtful: it is tried without where a straight
line says so, and left out where its interval does not tell it."""

MUCH, SCATTER = 10.0, 2.12
"""A finding that gains less than so many times what a name needs also has to gain that many standard errors of what
stretches of the recordings scatter by (98 %, one-sided). Beside nearly right laws of two seeds nobody had looked into,
six that were false gained 2.5 to 9 times the need and 1.3 to 2.1 standard errors, as an offset of 0.15° beside play; of
24 that were true those that gained so little gained 2.8 of them. What gains more may show in a single stretch, as a
stop does."""
PARTS = 10
"""Of fewer stretches nobody knows what they scatter by: 1.64 of these errors are asked there (95 %), and only of what
is doubtful."""

Say = Callable[[str], None]


class Round:
    """One round of the search, around an accepted model.

    Args:
        simulations: of the problem.
        at: the accepted model, with the derivatives that are known of it.
        everyone: the suspects that are looked at.
        limit: what a finding has to gain.
        nothing: the scenario's own model.
        say: told what is found.
        budget: how long to look for something better than what was found.
        known: responses beside a model near by, which are taken for those beside this one.

    Attributes:
        budget: the same, which grows where a round explains much (`search_budget.AGAIN`).
        explained: the evidence that the accepted model has more than the scenario's own.
        criterion: by which models are compared.
        told: the accepted model, fitted as if laws were exact, which tells its values best; None where it was moved to.
        now: the same where its evidence is best, for comparisons: the best fit of it that is known (`led`).
        look: the same, in the metric in which moves are looked for.
        blocks: responses of everything that could be added.
        lines: the linearised model of all blocks.
        linear_gains: what each gains in the linearised model, best first.
        candidates: what gains most, simulated where the linearised model leads, best first.
        short: of what was fitted and gains too little, what it gains and what it would have to.
        beaten: findings in whose place an unnamed effort gains what a name has to, though it is none itself.
        near: models that gain what their findings need if laws were exact, and less than laws leave.
    """

    def __init__(
        self,
        simulations: Simulations,
        at: Fit,
        everyone: Sequence[Suspect],
        limit: float,
        nothing: Fit,
        say: Say,
        budget: SearchBudget = UNLIMITED,
        known: Sequence[Block] = (),
    ) -> None:
        self.simulations, self.everyone, self.limit, self.say = simulations, list(everyone), limit, say
        self.budget = budget
        self.criterion = criterion = Criterion(simulations, at.changes)
        first = demanded(simulations, at.changes, criterion.train)
        criterion.set_effective_fraction(first)
        start = criterion.score(replace(at, residual=first))  # what is free is known from before where no fit is found
        done = criterion.fit(at.changes, at) if any(c.free for c in at.changes) else None
        self._at = (start if done is None else criterion.elsewhere(done)).fit
        self._nothing = nothing
        accepted, possible = [c.suspect for c in at.changes], set(criterion.possible(self._at, everyone))
        beside = [b for b in known if b.suspect in possible and stands_beside(b.suspect, accepted)]
        self.blocks: list[Block] = beside
        self.told: Scored | None = None
        self.short: dict[Suspect, tuple[float, float]] = {}
        self.beaten: set[Suspect] = set()
        self.near: list[Scored] = []
        self._looks = 0.0
        there = {b.suspect for b in beside}
        self._stand([s for s in everyone if s not in there])

    def at(self, other: Fit) -> Round:
        """The same round around another model."""
        return Round(self.simulations, other, self.everyone, self.limit, self._nothing, self.say, self.budget)

    def widened(self, everyone: Sequence[Suspect]) -> None:
        """Look at more suspects, from the same fit. The criterion by which models are compared has the discrepancy of
        all of them, so that what was scored before counts no longer.
        """
        known = set(self.everyone)
        self.everyone, self._at = list(everyone), self.retold().fit
        self._stand([s for s in everyone if s not in known])

    def _stand(self, more: Sequence[Suspect]) -> None:
        """Where the round stands, with the responses of more suspects."""
        criterion, say, before = self.criterion, self.say, self.simulations.steps
        self.blocks = [*self.blocks, *criterion.responses(self._at, more)]
        self._looks += self.simulations.steps - before
        criterion.set_discrepancy(self._at, self.blocks)
        self.told, self.now = criterion.score(self._at), criterion.settled(self._at)
        self._led, self._began = False, self.now.evidence
        self._bare = criterion.score(self._nothing)
        self.explained = self.now.evidence - self._bare.evidence
        say(
            f"evidence {self.now.evidence:.1f}, {len(self.blocks)} starts; laws imperfect by "
            + ", ".join(f"{scale:g} ({law or 'other'})" for law, scale in self.now.discrepancy_scale.items())
        )
        self._looked()

    def _looked(self) -> None:
        """The predicted gains of everything beside the accepted model."""
        self.look = self.criterion.sharp(self.now.fit)
        self.lines = linear_at(self.look, self.blocks)
        self.linear_gains = self.lines.gains()
        if self.late and any(c.free for c in self.now.fit.changes):  # nothing is added any more
            self.candidates = self.linear_gains
            return
        followed = self._followed(self.linear_gains)
        self.candidates = sorted([*followed, *self._jumps()], key=lambda p: -p.gain)

    def moved(self, to: Scored) -> bool:
        """Go on at another model with what is known here; False where that is too far.

        Laws are as far off as they were where the round began. So what models gain from there on has to be so little
        that what new laws leave of it is no finding. What others do is taken to be what it was, but for what stands in
        the place of something now, which is simulated.
        """
        gained = to.evidence - self._began
        if (max(DISCREPANCY_SCALES) * max(SHARE.values())) ** 2 * gained > self.limit:
            return False
        accepted = [c.suspect for c in to.fit.changes]
        gone = [c.suspect for c in self.now.fit.changes if c.suspect not in accepted]
        self.blocks = [b for b in self.blocks if stands_beside(b.suspect, accepted)]
        known = {b.suspect for b in self.blocks}
        freed = [s for s in self.everyone if s not in known and not stands_beside(s, gone)]
        self.blocks += self.criterion.responses(to.fit, freed)
        self.explained += to.evidence - self.now.evidence
        self.now, self.told, self._led = to, None, True
        self._looked()
        return True

    def adjusted(self, changes: Sequence[Change], known: Fit | None = None) -> Scored | None:
        """A model near a fitted one (the accepted), fitted quickly; None where it cannot be simulated."""
        return self.criterion.fit(changes, known or self.now.fit, "quick")

    @property
    def late(self) -> bool:
        """Whether to look for nothing better than what was found."""
        return self.budget.over(self.simulations.steps)

    @property
    def last(self) -> bool:
        """Whether there is no time to look at all anew."""
        return self.budget.over(self.simulations.steps + self._looks)

    def spare(self, scored: Scored) -> float:
        """The evidence of a model beyond what its findings have to gain."""
        return scored.evidence - self.limit * len(scored.fit.changes)

    def little(self, scored: Scored) -> float:
        """What laws leave of what is explained, where a model differs from the accepted one. Where a round gains less,
        the search ends. Laws are those of the kinds of what is new in a model, which is what they could be taken for;
        all of them where nothing is new.

        Of a UR10e whose friction was uneven, the mass of the last link was refused for what friction leaves, and the
        load that was fixed to it came out 19 % too heavy.
        """
        here = {c.suspect for c in self.now.fit.changes}
        new = {c.suspect.kind.law for c in scored.fit.changes if c.suspect not in here}
        return self.leaves(scored, new, self.now)

    def leaves(self, scored: Scored, laws: Collection[str], other: Scored) -> float:
        """What laws of some kinds, as far off as recordings say that they are, leave of what is explained, where two
        models differ: the square of what they are off by, and no more than what explains that may be off by itself. All
        of them where none of these is known. A delay explained all but 97 of 5500, and viscous friction was refused
        beside it, since friction may be off by 16 %: a delay leaves what is not known of a delay.

        Where a motion is followed, friction of the shoulder that is a little off is no effort of the elbow: of a UR10e
        the viscous friction of the elbow was refused for what laws of six joints leave. Where it is simulated, what is
        off at one joint moves all of them, further than the linearised model tells.
        """
        known = set(SHARE).intersection(laws)
        alike = [scale * SHARE[law] for law, scale in scored.discrepancy_scale.items() if law in (known or SHARE)]
        named = [
            scored.discrepancy_scale.get(s.kind.law, 1.0) * known_to(s) for s in (c.suspect for c in other.fit.changes)
        ]
        every = min(max(alike, default=WORST), max(named, default=np.inf)) ** 2 * self.explained
        cases, train = self.simulations.problem.cases, self.criterion.train
        if any(cases[c].experiment.followed is None for c in train):
            return every
        change = scored.fit.residual - other.fit.residual
        return every * reached(self.criterion.channels, (self.now, self._bare), change)

    def earned(self, more: Scored, fewer: Scored, needs: float) -> bool:
        """Whether a model gains enough over one with less in it."""
        return more.evidence - fewer.evidence >= self.asked(more, fewer, needs)

    def asked(self, more: Scored, fewer: Scored, needs: float) -> float:
        """What a model has to gain over one with less in it: what is needed, and, where it gains not much more, what
        stretches of the recordings scatter by.
        """
        gain, watched = more.evidence - fewer.evidence, self.criterion.channels
        many = int(stretches(watched).max()) + 1 >= PARTS
        if not needs <= gain < (MUCH if many else DOUBTFUL) * needs:
            return needs
        return max(needs, (SCATTER if many else ERRORS) * compare(watched, more, fewer)[1])

    def led(self, other: Scored) -> None:
        """Fit the accepted model anew from where another one led, and keep that where it has more evidence: what
        another model gains by fitting better is no gain of its own.
        """
        there = {(c.suspect, c.free): c for c in other.fit.changes}
        again = self.adjusted([there.get((c.suspect, c.free), c) for c in self.now.fit.changes], other.fit)
        if again is not None and again.evidence > self.now.evidence and not self.criterion.absurd(again):
            self.now, self._led = again, True

    def retold(self) -> Scored:
        """The accepted model, fitted as if laws were exact: also from where other models led, if that is likelier."""
        again = self.criterion.fit(self.now.fit.changes, self.now.fit) if self._led else None
        known = [s for s in (self.told, again) if s is not None]
        return max(known, key=lambda s: self.criterion.plain(s.fit).evidence, default=self.now)

    def likely(self, number: int) -> list[Suspect]:
        """So many suspects of most predicted gain, those of a plain fit, and the accepted effects, in order of all."""
        ranked = [*self.candidates, *self.linear_gains]
        best = set(list(dict.fromkeys(p.block.suspect for p in ranked))[:number])
        problem = self.simulations.problem
        here = {c.suspect.effect for c in self.now.fit.changes}
        if at_once(problem):  # the other joints' responses come with those of one
            here |= {s.effect for s in best if single(s)}
        return [s for s in self.everyone if s in best or s.effect in here or everyday(problem, s)]

    def _jumps(self) -> list[LinearGain]:
        """Tries that are far from linear, as a slippery ground or a stop, by the evidence that they have."""
        plain = self.criterion.plain(self.now.fit)
        here = plain.metric(plain.fit.residual)

        def nearer(block: Block) -> float:
            there = here + plain.metric(block.columns[:, 0])
            return float(here @ here - there @ there)

        far = [b for b in self.blocks if b.columns.shape[1] == 1]
        far = [b for b in far if b.start.kind != "linear" or b.suspect.kind.sits_at == "ground"]
        far = sorted(far, key=nearer, reverse=True)[:GLANCED]
        gains = self.simulations.side_by_side(
            lambda b: self.criterion.plain(self._moved(b.columns[:, 0])).evidence - plain.evidence, far
        )
        rough: dict[tuple[Suspect, tuple[str, ...]], tuple[float, Block]] = {}
        for block, gain in zip(far, gains, strict=True):
            which = block.suspect, block.start.first.free
            if gain > rough.get(which, (0.0, block))[0]:
                rough[which] = gain, block
        out = []
        for _, block in sorted(rough.values(), key=lambda r: -r[0])[: 2 * BEAM]:
            try_ = block.start.tries[0]
            whole = Start(try_, (try_,), block.start.zero, "whole")
            out.append(LinearGain(Block(whole, block.columns), (1.0,), self.gain(block.columns[:, 0])))
        return sorted((p for p in out if p.gain > 0.0), key=lambda p: -p.gain)[:BEAM]

    def gain(self, change: Array) -> float:
        """The evidence that a change of the accepted model's residual gains, (m,), in the metric of moves."""
        return self.criterion.sharp(self._moved(change)).evidence - self.look.evidence

    def _moved(self, change: Array) -> Fit:
        """The accepted model with its residual changed as a try does, as it is. Shape (m,)."""
        return replace(self.now.fit, residual=self.now.fit.residual + change)

    def _followed(self, linear_gains: Sequence[LinearGain]) -> list[LinearGain]:
        """The suspects of most linear gain, simulated where the linearised model leads, by the evidence there.

        With less that no law explains, recordings tell more than the linearised model predicts.
        """
        chosen: list[LinearGain] = []
        for p in linear_gains:
            kin = [c for c in chosen if c.block.suspect.effect == p.block.suspect.effect]
            same = [c for c in kin if c.block.suspect == p.block.suspect]
            if p.gain > 0.0 and len(chosen) < DEEP and len(same) < 2 and len(kin) < 4:
                chosen.append(p)
        variants = [(p, f) for p in chosen for f in (FOLLOWED if p.block.start.kind != "whole" else (1.0,))]
        changes = [p.block.start.at([a * f for a in p.amounts]) for p, f in variants]
        accepted, plant = self.now.fit.changes, self.simulations.problem.plant
        models = [as_read([*accepted, c], accepted, plant) for c in changes]
        still, *answers = self.criterion.motions.residuals([accepted, *models])
        if still is None:
            return chosen
        there = [
            (p, Block(Start(change, (change,), p.block.start.zero, "whole"), np.nan_to_num(answer - still)[:, None]))
            for (p, _), change, answer in zip(variants, changes, answers, strict=True)
            if answer is not None
        ]
        gains = self.simulations.side_by_side(lambda of: self.gain(of[1].columns[:, 0]), there)
        best: dict[int, LinearGain] = {}
        for (p, block), gain in zip(there, gains, strict=True):
            if id(p) not in best or gain > best[id(p)].gain:
                best[id(p)] = LinearGain(block, (1.0,), gain)
        return sorted(best.values(), key=lambda p: -p.gain)


def told_change(change: Change) -> str:
    """A change in words, with its fitted values."""
    if change.suspect.table is not None:
        return f"{change.suspect} ({len(change.values)} values)"
    return f"{change.suspect} " + ", ".join(f"{n} {v:.4g}" for n, v in change.values if n in change.free)
