"""The search: from the scenario's model to the one with the best evidence, by adding, exchanging and dropping."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from realitygap.diagnose.candidates.starts import Start
from realitygap.diagnose.candidates.suspects import fitted, richer
from realitygap.diagnose.data.changes import Change, Suspect, clash
from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.fit.fit import Fit
from realitygap.diagnose.fit.responses import Block, residual, residuals
from realitygap.diagnose.likelihood.floors import Floors
from realitygap.diagnose.search.evidence import Scored
from realitygap.diagnose.search.exchange import Rival, compare, without
from realitygap.diagnose.search.linear import Linear, Promise
from realitygap.diagnose.search.model import Ground
from realitygap.robot.effects import EFFECTS

BEAM = 4
"""Suspects that are fitted in a round: those that promise most."""
DEEP = 14
"""Suspects that are simulated at the amount that they promise."""
FOLLOWED = (0.5, 1.0, 2.0)
"""What that amount is multiplied by: a straight line may lead too far, or end too early."""
EXCHANGED = 4
"""Suspects that are fitted in the place of a finding."""
SURE = 3.0
"""A gain in evidence beyond the logarithm of the number of suspects: odds of 20 to 1 against chance for all of them."""
EQUAL = 1.0
"""Models whose evidence differs by less are equal: the simpler one is named."""
ROUNDS = 30
"""Rounds at most: more findings than this no page could show."""

Say = Callable[[str], None]


@dataclass
class Found:
    """What a search found.

    Attributes:
        base: the scenario's own model, on the ground of the last round.
        best: the model with the best evidence.
        limit: what a finding has to gain.
        floors: of the best model.
        gains: evidence that is lost without each finding, by suspect.
        rivals: what could stand in the place of each finding, the closest first.
        promised: what was closest and not taken, best first.
    """

    base: Scored
    best: Scored
    limit: float
    floors: Floors
    gains: dict[Suspect, float] = field(default_factory=dict)
    rivals: dict[Suspect, list[Rival]] = field(default_factory=dict)
    promised: list[Promise] = field(default_factory=list)


def search(simulations: Simulations, everyone: Sequence[Suspect], told: Sequence[Change], say: Say) -> Found:
    """Search until no move gains enough.

    Args:
        simulations: of the problem.
        everyone: the suspects.
        told: changes that the recordings show by themselves; they stay.
        say: told what is being done.
    """
    limit = needed(len(everyone))
    changes, seen, grows = tuple(told), set[frozenset[Suspect]](), True
    for _ in range(ROUNDS):
        round_ = Round(simulations, changes, everyone, limit, say)
        here = frozenset(c.suspect for c in round_.now.fit.changes)
        grows = grows and here not in seen  # what was dropped here once would only be added again
        seen.add(here)
        following = round_.grown() if grows else None
        if following is None:
            following = round_.exchanged(keep=[c.suspect for c in told])
            if following is not None and len(following.fit.changes) == len(here):
                following = None if frozenset(c.suspect for c in following.fit.changes) in seen else following
        if following is None:
            break
        changes = following.fit.changes
        say("; ".join(told_change(c) for c in changes))
    base = residual(simulations, told, round_.ground.train)
    assert base is not None
    found = Found(round_.ground.score(Fit(tuple(told), base)), round_.now, limit, round_.ground.floors)
    found.gains, found.rivals, found.promised = round_.gains, round_.rivals, round_.promised
    return found


def needed(suspects: int) -> float:
    """The gain in evidence that a name needs among so many suspects."""
    return float(np.log(max(suspects, 1))) + SURE


def simpler(problem: Problem, a: Suspect, b: Suspect) -> bool:
    """Whether one suspect has fewer parameters than another, or as many and stands before it in the table.

    On a linear axis without a stated armature, inertia is the link's mass.
    """
    order = list(EFFECTS)

    def place(suspect: Suspect) -> tuple[int, float]:
        joints, drive = problem.plant.model.joints, problem.plant.drive
        linear = suspect.effect == "rotor_inertia" and all(
            joints[i].prismatic and not drive["armature"][i] for i in suspect.indices
        )
        return len(fitted(suspect.kind)), order.index("link_mass") + 0.5 if linear else order.index(suspect.effect)

    return place(a) < place(b)


class Round:
    """One round of the search, around an accepted model."""

    def __init__(
        self, simulations: Simulations, changes: Sequence[Change], everyone: Sequence[Suspect], limit: float, say: Say
    ) -> None:
        self.simulations, self.everyone, self.limit, self.say = simulations, list(everyone), limit, say
        self.ground = ground = Ground(simulations, changes)
        self.gains: dict[Suspect, float] = {}
        self.rivals: dict[Suspect, list[Rival]] = {}
        first = residual(simulations, changes, ground.train)
        if first is None:
            raise RuntimeError("the model that the search stands at cannot be simulated")
        ground.take_facts(Fit(tuple(changes), first))
        start = ground.score(Fit(tuple(changes), first))
        done = ground.fit(changes, start.metric) if any(c.free for c in changes) else None
        self.now = start if done is None else ground.elsewhere(ground.settled(done))
        ground.take_facts(self.now.fit)
        self.blocks = ground.responses(self.now.fit, everyone)
        ground.take_imperfections(self.now.fit, self.blocks)
        self.now = ground.score(self.now.fit)
        self.look = ground.sharp(self.now.fit)
        say(f"evidence {self.now.evidence:.1f}, laws imperfect by {self.now.imperfect:g}; {len(self.blocks)} starts")
        followed = self._followed(linear_at(self.look, self.blocks).promises())
        self.promised = sorted([*followed, *self._jumps()], key=lambda p: -p.gain)

    def grown(self) -> Scored | None:
        """The best model with one more finding, several, a richer shape, or a value for every joint of a group; None
        where none gains enough.

        What each way gains is judged beyond what it needs: the limit for every finding, and for a shape odds of 20 : 1.
        """
        accepted = list(self.now.fit.changes)
        first: dict[Suspect, Promise] = {}
        for p in self.promised:
            first.setdefault(p.block.suspect, p)
        ways = [([*accepted, p.block.start.first], self.limit) for p in list(first.values())[:BEAM] if p.gain > 0]
        several = linear_at(self.look, [p.block for p in self.promised]).several(self.limit)
        if len(several) > 1:
            ways.append(([*accepted, *(p.block.start.first for p in several)], self.limit * len(several)))
        for k, change in enumerate(accepted):
            beside = [*accepted[:k], *accepted[k + 1 :]]
            shaped = richer(self.simulations.problem.plant, change)
            if shaped is not None and change.free and shaped.free != change.free:
                ways.append(([*beside, shaped], SURE))
            each = self._each(change, beside)
            if each and change.free:
                ways.append(([*beside, *each], self.limit * (len(each) - 1)))
        best, most = None, 0.0
        for way, needs in ways:
            scored = self.ground.fit(way, self.look.metric)
            if scored is None:
                continue
            gain = scored.evidence - self.now.evidence
            here = {a.suspect for a in accepted}
            new = [c for c in scored.fit.changes if c.suspect not in here]
            self.say(f"  {'; '.join(told_change(c) for c in new or scored.fit.changes)}: {gain:+.1f}")
            if gain - needs > most:
                best, most = scored, gain - needs
        return best

    def _each(self, change: Change, beside: Sequence[Change]) -> list[Change]:
        """The change of a group as one at every joint of it; none where it is at one joint."""
        group = change.suspect
        if len(group.indices) < 2:
            return []
        alone = [s for s in self.everyone if s.effect == group.effect and len(s.indices) == 1]
        inside = [s for s in alone if s.indices[0] in group.indices]
        free = [s for s in inside if not any(clash(s, b.suspect) for b in beside)]
        return [replace(change, suspect=s) for s in free] if len(free) > 1 else []

    def exchanged(self, keep: Sequence[Suspect]) -> Scored | None:
        """A model that is better with a finding dropped or exchanged; None where there is none.

        Fills `gains` and `rivals` on the way.
        """
        best: Scored | None = None
        for k, change in enumerate(self.now.fit.changes):
            if change.suspect in keep:
                continue
            rest = without(self.now.fit.changes, k)
            alone = self.ground.fit(rest, self.now.metric)
            if alone is None:
                continue
            alone = self.ground.settled(alone)
            gain = self.now.evidence - alone.evidence
            self.gains[change.suspect] = gain
            if gain < self.limit:
                self.say(f"  without {change.suspect}: {-gain:+.1f}")
                best = alone if best is None or alone.evidence > best.evidence else best
                continue
            self.rivals[change.suspect] = self._rivals(change, rest, alone)
            for rival in self.rivals[change.suspect]:
                equal = rival.behind < EQUAL and simpler(self.simulations.problem, rival.suspect, change.suspect)
                ahead = rival.behind < -EQUAL or equal
                if ahead and (best is None or rival.scored.evidence > best.evidence):
                    best = rival.scored
        return best

    def _rivals(self, change: Change, rest: Sequence[Change], alone: Scored) -> list[Rival]:
        """What explains nearly as much in the place of a finding, the closest first."""
        here = [b for b in self.blocks if not any(clash(b.suspect, c.suspect) for c in rest)]
        known = {b.suspect for b in here}
        clashing = [
            s
            for s in self.everyone
            if s not in known and s != change.suspect and clash(s, change.suspect)
            and not any(clash(s, c.suspect) for c in rest)
        ]  # fmt: skip
        here += self.ground.responses(alone.fit, clashing)
        promised = linear_at(self.ground.sharp(alone.fit), here).promises()
        chosen: dict[Suspect, Promise] = {}
        for p in promised:
            if p.gain > 0 and len(chosen) < EXCHANGED:
                chosen.setdefault(p.block.suspect, p)
        out = []
        for suspect, p in chosen.items():
            scored = self.ground.fit([*rest, p.change], self.look.metric)
            if scored is not None:
                out.append(compare(self.ground.channels, self.now, scored, suspect))
                self.say(f"  {suspect} for {change.suspect}: {-out[-1].behind:+.1f} ± {out[-1].error:.1f}")
        return sorted(out, key=lambda r: r.behind)

    def _jumps(self) -> list[Promise]:
        """Tries that are far from a straight line, as a slippery ground or a stop, by the evidence that they have."""
        out = []
        for block in self.blocks:
            if block.columns.shape[1] == 1 and (block.start.kind != "linear" or block.suspect.kind.sits_at == "ground"):
                there = replace(self.now.fit, residual=self.now.fit.residual + block.columns[:, 0])
                gain = self.ground.sharp(there).evidence - self.look.evidence
                if gain > 0.0:
                    try_ = block.start.tries[0]
                    whole = Start(try_, (try_,), block.start.zero, "whole")
                    out.append(Promise(Block(whole, block.columns), (1.0,), gain))
        best: dict[Suspect, Promise] = {}
        for p in sorted(out, key=lambda p: -p.gain):
            best.setdefault(p.block.suspect, p)
        return list(best.values())[:BEAM]

    def _followed(self, promises: Sequence[Promise]) -> list[Promise]:
        """The suspects that promise most, simulated where their straight lines lead, and taken as lines from there."""
        chosen: list[Promise] = []
        for p in promises:
            kin = [c for c in chosen if c.block.suspect.effect == p.block.suspect.effect]
            same = [c for c in kin if c.block.suspect == p.block.suspect]
            if p.gain > 0 and len(chosen) < DEEP and len(same) < 2 and len(kin) < 4:
                chosen.append(p)
        variants = [(p, f) for p in chosen for f in (FOLLOWED if p.block.start.kind != "whole" else (1.0,))]
        changes = [p.block.start.at([a * f for a in p.amounts]) for p, f in variants]
        accepted = self.now.fit.changes
        still, *answers = residuals(
            self.simulations,
            [accepted, *([*accepted, c] for c in changes)],
            self.ground.train,
            self.ground.floors.coarse,
        )
        if still is None:
            return chosen
        there: list[tuple[Promise, Block]] = []
        for (p, _), change, answer in zip(variants, changes, answers, strict=True):
            if answer is not None:
                start = Start(change, (change,), p.block.start.zero, "whole")
                there.append((p, Block(start, np.nan_to_num(answer - still)[:, None])))
        linear = linear_at(self.look, [block for _, block in there])
        best: dict[int, Promise] = {}
        for k, (p, _) in enumerate(there):
            followed = linear.promise(k)
            if id(p) not in best or followed.gain > best[id(p)].gain:
                best[id(p)] = followed
        return sorted(best.values(), key=lambda p: -p.gain)


def linear_at(at: Scored, blocks: Sequence[Block]) -> Linear:
    """The straight-line model around a fit, in its own metric."""
    return Linear(at.metric, at.fit.residual, at.fit.slope, blocks)


def told_change(change: Change) -> str:
    """A change in words, with its fitted values."""
    return f"{change.suspect} " + ", ".join(f"{n} {v:.4g}" for n, v in change.values if n in change.free)
