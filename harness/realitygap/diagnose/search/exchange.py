"""What else could stand in the place of a finding: exchanged, fitted, and compared by evidence.

The same comparison says three things: whether another name is better, how much better the name is than the next best
explanation, and which names the recordings cannot tell apart (a model confidence set, Hansen, Lunde & Nason 2011, with
the test of Vuong 1989: the difference in evidence beside its standard error over stretches of the recordings).
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

from realitygap.diagnose.data.changes import Change, Suspect, stands_beside
from realitygap.diagnose.search.evidence import EQUAL, Scored
from realitygap.diagnose.search.pairs import pairs_for
from realitygap.diagnose.search.prune import pruned, superfluous
from realitygap.diagnose.search.rivals import FAR, LATE, LOOKED, ODDS, Place, Rival, rivals_of, several_for
from realitygap.diagnose.search.round import Round
from realitygap.diagnose.search.simpler import narrower, simpler
from realitygap.diagnose.search.special_case import no_more
from realitygap.diagnose.search.without import PLAIN, without

TOGETHER = 4
"""Findings that are asked at once for what could stand in their place; before the next ones it is asked whether it is
late."""


@dataclass
class Exchanged:
    """What could be left out or exchanged.

    Attributes:
        better: a model that is better for it; None where there is none.
        plainer: whether that is so by the simpler name of a finding.
        gains: evidence that is lost without each finding, by suspect.
        without: the model without each finding, its other values fitted anew.
        rivals: what could stand in the place of each finding, the closest first.
        fuller: the model from which findings were left out, as they gain too little; None where none was.
    """

    better: Scored | None = None
    plainer: bool = False
    gains: dict[Suspect, float] = field(default_factory=dict)
    without: dict[Suspect, Scored] = field(default_factory=dict)
    rivals: dict[Suspect, list[Rival]] = field(default_factory=dict)
    fuller: Scored | None = None

    def forget_beside(self, now: Scored) -> bool:
        """Forget what was told of findings beside others that have gone from a model; whether there was any."""
        here = {c.suspect for c in now.fit.changes}
        stale = [s for s, alone in self.without.items() if not here.issuperset(c.suspect for c in alone.fit.changes)]
        for suspect in stale:
            del self.without[suspect], self.gains[suspect]
        return bool(stale)

    def offer(self, other: Scored, round_: Round, plainer: bool = False) -> None:
        """Take a model that is better than those before, beyond what its findings have to gain."""
        if self.better is None or round_.spare(other) > round_.spare(self.better):
            self.better, self.plainer = other, plainer


def exchanged(round_: Round, keep: Sequence[Suspect], before: Exchanged) -> Exchanged:
    """Every finding left out, and exchanged for what would gain most in its place; `keep` stays.

    Where one is superfluous, that is all that is said, unless it is late: then nothing new is looked for beside what is
    left. What was far behind `before` is not tried again. A name that is no simpler has to gain what a new one has to
    (`Round.little`), and to be the better one surely: a load of 58 g at a forearm, with four values, gained 3 ± 3 in
    the place of an upper arm's centre of mass. Once it is late, so has every one.
    """
    now = pruned(round_, round_.now, keep, told=True)
    out = Exchanged()
    while True:
        doubtful = [c.suspect for c in now.fit.changes if c.suspect not in keep and _in_doubt(out, c.suspect, round_)]
        fitted = round_.simulations.side_by_side(partial(without, round_, now), doubtful)
        for suspect, alone in zip(doubtful, fitted, strict=True):
            if alone is not None:
                out.without[suspect] = alone
                out.gains[suspect] = now.evidence - alone.evidence
        spare = [s for s in doubtful if s in out.without and not round_.earned(now, out.without[s], round_.limit)]
        if spare:
            now = out.without.pop(max(spare, key=lambda s: out.without[s].evidence))
        elif not (round_.late and out.forget_beside(now)):
            break
    fuller = round_.now
    gone = len(fuller.fit.changes) - len(now.fit.changes)
    if gone:
        round_.say(f"  without {gone}: {now.evidence - fuller.evidence:+.1f}")
        if not (round_.late and round_.moved(now)):
            return Exchanged(better=now, rivals=before.rivals, fuller=fuller)
        out.fuller = fuller
    return _compared(round_, keep, out, before)


def renamed(round_: Round, keep: Sequence[Suspect], new: Collection[Suspect]) -> Scored | None:
    """The best model with another name in the place of one of the newest findings; None where none is better. What is
    added beside a wrong name mends it, until the right one gains nothing in its place.
    """
    out = Exchanged()
    asked = [c.suspect for c in round_.now.fit.changes if c.suspect in new]
    fitted = round_.simulations.side_by_side(partial(without, round_, round_.now), asked)
    out.without = {suspect: alone for suspect, alone in zip(asked, fitted, strict=True) if alone is not None}
    return _compared(round_, keep, out, Exchanged(), few=True).better


def _compared(
    round_: Round, keep: Sequence[Suspect], out: Exchanged, before: Exchanged, few: bool = False
) -> Exchanged:
    """What could stand in the place of every finding without which the model is known: of all suspects or of a few."""
    asked, evidence = [c for c in round_.now.fit.changes if c.suspect in out.without], round_.now.evidence

    def close(change: Change, late: bool) -> tuple[list[Rival], Scored | None]:
        rivals, alone = before.rivals.get(change.suspect, []), out.without[change.suspect]
        if rivals and all(r.behind >= FAR * round_.limit for r in rivals):
            return rivals, None
        place = Place.of(round_, change, alone, late, 2 * LATE if late or few else LOOKED)
        near = rivals_of(place, rivals)
        pairs = [] if late or few else pairs_for(place, near)
        return [*near, *pairs], None if late else several_for(place)

    found: dict[Suspect, tuple[list[Rival], Scored | None]] = {}
    for begin in range(0, len(asked), TOGETHER):
        some = asked[begin : begin + TOGETHER]
        answers = round_.simulations.side_by_side(partial(close, late=round_.late), some)
        found |= zip((c.suspect for c in some), answers, strict=True)
    compared = {suspect: rivals for suspect, (rivals, _) in found.items()}
    better = [r for of in compared.values() for r in sorted(of, key=lambda r: -r.behind) if r.behind < -ODDS]
    ahead = {r.suspects: r for r in better}
    for rival in ahead.values():  # one that is better in the place of several leads to the same
        round_.led(rival.scored)
    for suspect, rivals in compared.items():
        further = round_.now.evidence - evidence
        out.rivals[suspect] = sorted((replace(r, behind=r.behind + further) for r in rivals), key=lambda r: r.behind)
        out.gains[suspect] = round_.now.evidence - out.without[suspect].evidence
        for rival in out.rivals[suspect]:
            alone = out.without[suspect]
            plainer, gains = _plainer(round_, rival, suspect, alone), _gains(round_, rival, suspect, alone)
            if (plainer and not round_.late) or (gains and rival.ahead):
                out.offer(rival.scored, round_, plainer)
            shorter = None if round_.late or rival.behind > FAR * round_.limit else _shorter(round_, rival.scored, keep)
            if shorter is not None:
                out.offer(shorter, round_)
    for several in [several for _, several in found.values()] + [_in_turn(round_, out.rivals)]:
        if several is not None:
            out.offer(several, round_)
    return out


def _plainer(round_: Round, rival: Rival, finding: Suspect, alone: Scored) -> bool:
    """Whether a rival is the simpler name of a finding, and says as much; of a finding that says more of the same law,
    as much but for what such laws are off by, or what is too little to decide; of an effort without a law, as much but
    for what was thought beforehand.

    Dry friction of 1.02 N·m, of a joint whose friction was 5 % more at creeping, was called a Stribeck friction.
    Viscous friction of 0.154 N·m·s/rad beside an inertia was left an effort over the speed with two values, 3.9 ahead.
    """
    if rival.beside is not None or not simpler(round_.simulations.problem, rival.suspect, finding):
        return False
    if finding.table is not None and rival.same:
        return True
    if not narrower(rival.suspect, finding):
        return rival.behind < EQUAL or _gains(round_, rival, finding, alone)
    return no_more(round_.criterion, round_.now, rival.scored, finding, alone, round_.limit)


def _gains(round_: Round, rival: Rival, finding: Suspect, alone: Scored) -> bool:
    """Whether a rival gains what a new name has to, and no less where it says more of the same law than laws are off
    by.
    """
    more = round_.limit * (len(rival.suspects) - 1)
    if -rival.behind <= max(ODDS, more, round_.little(rival.scored)):
        return False
    richer = rival.beside is None and narrower(finding, rival.suspect)
    return not (richer and no_more(round_.criterion, rival.scored, round_.now, rival.suspect, alone, round_.limit))


def _in_turn(round_: Round, rivals: Mapping[Suspect, Sequence[Rival]]) -> Scored | None:
    """The model with findings exchanged in turn, of those for which another name is surely better, the surest first;
    None where no more than one of them is, beside the others. What is exchanged alone leaves the other wrong names to
    be found out beside what it mends, with fits that may be rough, or with no time left: an offset of 0.16 rad beside
    play stayed for an effort, and friction by side, 26 ahead, was not asked for again once a load was named.
    """
    single = {s: [r for r in of if r.beside is None] for s, of in rivals.items()}
    sure = sorted(((of[0], s) for s, of in single.items() if of and of[0].ahead), key=lambda a: a[0].behind)
    if not sure:
        return None
    (first, _), *others = sure
    best = first.scored
    for rival, gone in others:
        rest = [c for c in best.fit.changes if c.suspect != gone]
        new = [c for c in rival.scored.fit.changes if c.suspect == rival.suspect]
        if not stands_beside(rival.suspect, [c.suspect for c in rest]):
            continue
        quick = round_.adjusted([*rest, *new], best.fit)
        scored = None if quick is None else round_.criterion.refined(quick)
        if scored is not None:
            gain = scored.evidence - best.evidence
            round_.say(f"  {rival.suspect} for {gone}, too: {gain:+.1f}")
            best = scored if gain > ODDS else best
    return None if best is first.scored else best


def _shorter(round_: Round, rival: Scored, keep: Sequence[Suspect]) -> Scored | None:
    """A rival's model without what it makes superfluous, where that says as much with fewer findings; None elsewhere.
    One supply for all joints, which does no more than that of one of them beside what the others were mended by, stands
    in the place of all of that.
    """
    if not superfluous(round_.simulations.problem, rival, keep, round_.limit):
        return None
    shorter = pruned(round_, rival, keep)
    fewer = len(shorter.fit.changes) < len(round_.now.fit.changes)
    return shorter if fewer and round_.spare(shorter) > round_.spare(round_.now) else None


def _in_doubt(out: Exchanged, suspect: Suspect, round_: Round) -> bool:
    """Whether it is open what a finding gains: it is not known yet, or little more than a name needs."""
    return suspect not in out.gains or out.gains[suspect] < PLAIN * round_.limit
