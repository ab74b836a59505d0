"""What else could stand in the place of a finding: exchanged, fitted, and compared by evidence.

The same comparison says three things: whether another name is better, how much better the name is than the next best
explanation, and which names the recordings cannot tell apart (a model confidence set, Hansen, Lunde & Nason 2011, with
the test of Vuong 1989: the difference in evidence beside its standard error over stretches of the recordings).
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial

import numpy as np

from realitygap.diagnose.candidates.starts import guess
from realitygap.diagnose.data.changes import Change, Suspect, as_read, clash
from realitygap.diagnose.fit.responses import Block
from realitygap.diagnose.search.alike import alike
from realitygap.diagnose.search.apart import ERRORS, compare
from realitygap.diagnose.search.evidence import EQUAL, Scored
from realitygap.diagnose.search.linear import Linear
from realitygap.diagnose.search.prune import pruned, superfluous
from realitygap.diagnose.search.round import Round
from realitygap.diagnose.search.simpler import simpler
from realitygap.diagnose.search.without import PLAIN, without

ODDS = 3.0
"""Difference in evidence (odds of 20 to 1) below which a rival stays in it anyway."""
LOOKED = 12
"""Suspects whose responses are simulated anew where a finding is missing: those that promise most by their responses
beside it. What does the same as the finding does little more once it is there (a gain beside a risen supply), or little
before (an offset of a joint that sticks): the better one of both counts."""
ROUGHLY = 0.05
"""Of these none that promises less than this share of what the finding gains: on the SO-101 those that came close
promised 0.10, 0.38 and 1.0 of it."""
EXCHANGED, LATE = 4, 2
"""Suspects that are tried in the place of a finding: of these, those that promise most. Fewer, of twice as many, once
there is no more time to find a better name for it."""
CLOSE = 0.75
"""Beside the one that promises most, those are tried that promise this share of what the finding does where it is
missing. On the SO-101, of 77 rivals that promised 0.25 of it or more, the nine that came close when they were fitted
promised 0.89 to 1.3 of it."""
BEYOND = 2
"""Suspects far from any straight line that are tried besides, from their first sizes: those that promise most. They
were simulated at few sizes, and promise too little."""
LOOSER = (1.0, 2.0, 4.0)
"""What the first size of a limit is multiplied by, where another fit is near by."""
FAR = 2.0
"""A rival that is further behind in a quick fit than this many times what a name needs is not fitted in full."""
TOGETHER = 4
"""Findings that are asked at once for what could stand in their place; before the next ones it is asked whether it is
late."""


@dataclass(frozen=True)
class Rival:
    """A model with another suspect in the place of a finding; `behind` is how much evidence it has less, `error` the
    standard error of that.
    """

    suspect: Suspect
    scored: Scored
    behind: float
    error: float

    @property
    def open(self) -> bool:
        """Whether the recordings cannot tell it from the finding, or it is the better one."""
        return self.behind <= max(ODDS, ERRORS * self.error)

    @property
    def ahead(self) -> bool:
        """Whether it is surely the better one."""
        return -self.behind > max(ODDS, ERRORS * self.error)


@dataclass
class Exchanged:
    """What could be left out or exchanged.

    Attributes:
        better: a model that is better for it; None where there is none.
        gains: evidence that is lost without each finding, by suspect.
        without: the model without each finding, its other values fitted anew.
        rivals: what could stand in the place of each finding, the closest first.
    """

    better: Scored | None = None
    gains: dict[Suspect, float] = field(default_factory=dict)
    without: dict[Suspect, Scored] = field(default_factory=dict)
    rivals: dict[Suspect, list[Rival]] = field(default_factory=dict)

    def offer(self, other: Scored, round_: Round) -> None:
        """Take a model that is better than those before, beyond what its findings have to gain."""
        if self.better is None or round_.spare(other) > round_.spare(self.better):
            self.better = other


def exchanged(round_: Round, keep: Sequence[Suspect], before: Exchanged) -> Exchanged:
    """Every finding left out, and exchanged for what promises most in its place; `keep` stays.

    Where one is superfluous, that is all that is said, unless it is late: then nothing new is looked for beside what is
    left. What was far behind `before` is not tried again. A name that is no simpler has to gain what a new one has to
    (`Round.little`); once it is late it has to be the better one surely.
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
        if not spare:
            break
        now = out.without.pop(max(spare, key=lambda s: out.without[s].evidence))
    gone = len(round_.now.fit.changes) - len(now.fit.changes)
    if gone:
        round_.say(f"  without {gone}: {now.evidence - round_.now.evidence:+.1f}")
        if not (round_.late and round_.moved(now)):
            return Exchanged(better=now, rivals=before.rivals)
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
        place = _Place.of(round_, change, alone, late, 2 * LATE if late or few else LOOKED)
        return _rivals(place, rivals), None if late else _several(place)

    found: dict[Suspect, tuple[list[Rival], Scored | None]] = {}
    for begin in range(0, len(asked), TOGETHER):
        some = asked[begin : begin + TOGETHER]
        answers = round_.simulations.side_by_side(partial(close, late=round_.late), some)
        found |= zip((c.suspect for c in some), answers, strict=True)
    compared = {suspect: rivals for suspect, (rivals, _) in found.items()}
    ahead = {r.suspect: r for of in compared.values() for r in sorted(of, key=lambda r: -r.behind) if r.behind < -ODDS}
    for rival in ahead.values():  # one that is better in the place of several leads to the same
        round_.led(rival.scored)
    for suspect, rivals in compared.items():
        further = round_.now.evidence - evidence
        out.rivals[suspect] = [replace(r, behind=r.behind + further) for r in rivals]
        out.gains[suspect] = round_.now.evidence - out.without[suspect].evidence
        for rival in out.rivals[suspect]:
            equal = rival.behind < EQUAL and simpler(round_.simulations.problem, rival.suspect, suspect)
            better = -rival.behind > max(ODDS, round_.little(rival.scored))
            if (better or equal) and (rival.ahead or not round_.late):
                out.offer(rival.scored, round_)
            shorter = None if round_.late or rival.behind > FAR * round_.limit else _shorter(round_, rival.scored, keep)
            if shorter is not None:
                out.offer(shorter, round_)
    for _, several in found.values():
        if several is not None:
            out.offer(several, round_)
    return out


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


@dataclass(frozen=True)
class _Place:
    """Where a finding is missing, and what could stand there.

    Attributes:
        round_: of the search.
        change: the finding.
        alone: the model without it.
        late: whether to look only for what could be told.
        blocks: the responses of what could, the finding's own among them.
        gain: the evidence that the finding gains, there or by its response, whichever is more.
    """

    round_: Round
    change: Change
    alone: Scored
    late: bool
    blocks: Sequence[Block]
    gain: float

    @classmethod
    def of(cls, round_: Round, change: Change, alone: Scored, late: bool, looked: int) -> _Place:
        """What promises anything there, so many of it simulated anew."""
        rest, gain = [c.suspect for c in alone.fit.changes], round_.now.evidence - alone.evidence

        def fits(suspect: Suspect) -> bool:
            return not any(clash(suspect, other) for other in rest)

        here = [b for b in round_.blocks if fits(b.suspect)]
        likely = [p for p in _lines(round_, alone, here).promises() if p.gain > ROUGHLY * gain]
        rough = list(dict.fromkeys(p.block.suspect for p in likely))[:looked]
        known = {b.suspect for b in here}
        beside = [s for s in round_.everyone if s not in known and s != change.suspect and clash(s, change.suspect)]
        far = [] if late else _far(round_, change.suspect)
        tried = [change.suspect, *rough, *(s for s in [*beside, *far] if fits(s))]
        anew = round_.yardstick.responses(alone.fit, list(dict.fromkeys(tried)))
        place = cls(round_, change, alone, late, [*anew, *(b for b in here if b.suspect in rough)], gain)
        own = (p.gain for p in place.lines.promises() if p.block.suspect == change.suspect)
        return replace(place, gain=max([gain, *own]))

    @cached_property
    def lines(self) -> Linear:
        """The straight-line model of what could stand there."""
        return _lines(self.round_, self.alone, self.blocks)

    @property
    def limits(self) -> list[Suspect]:
        """What is far from any straight line and leads the right way, as little of it as would; best first."""
        numbers = [i for i, b in enumerate(self.blocks) if b.start.kind == "whole"]
        gains = sorted(((self.lines.toward(i), i) for i in numbers), reverse=True)
        return list(dict.fromkeys(self.blocks[i].suspect for gain, i in gains if gain > 0.0))

    def quick(self, changes: Sequence[Change], beside: bool = False) -> Scored | None:
        """A model with other changes there, fitted quickly; or beside the others as they are with the finding."""
        rest = self.alone.fit.changes
        if beside:
            rest = tuple(c for c in self.round_.now.fit.changes if c.suspect != self.change.suspect)
        return self.round_.adjusted(as_read([*rest, *changes], rest, self.round_.simulations.problem.plant))


def _lines(round_: Round, alone: Scored, blocks: Sequence[Block]) -> Linear:
    """The straight-line model where a finding is missing.

    What explains nearly as much leaves as little as the model with the finding, in whose metric it is looked for: where
    the finding is missing, most of what it explains is taken for what no law does.
    """
    return Linear(round_.look.metric, alone.fit.residual, alone.fit.slope, blocks)


def _far(round_: Round, finding: Suspect) -> list[Suspect]:
    """What is far from any straight line at the joints of a finding, as a limit: what it does beside the finding, which
    does nearly the same, says nothing of what it does in its place.
    """
    whole = dict.fromkeys(b.suspect for b in round_.blocks if b.start.kind == "whole")
    return [s for s in whole if s != finding and set(s.joints) == set(finding.joints)]


def _sizes(limit: Change) -> list[Change]:
    """A limit at several multiples of its first size: from one that is too tight no fit finds back."""
    first = {n: v for n, v in limit.parameters.items() if n in limit.free and np.isfinite(v)}
    return [limit.at({n: looser * v for n, v in first.items()}) for looser in LOOSER]


def _rivals(place: _Place, before: Sequence[Rival]) -> list[Rival]:
    """What explains nearly as much in the place of a finding, the closest first."""
    round_, alone, yardstick = place.round_, place.alone, place.round_.yardstick
    same = {} if place.late else alike(round_, place.change)
    chosen = {suspect: [change] for suspect, change in same.items()}
    most = len(chosen) + (LATE if place.late else EXCHANGED)
    for p in place.lines.promises():
        worth = p.gain > (CLOSE * place.gain if chosen else 0.0)
        if worth and p.block.suspect != place.change.suspect and len(chosen) < most:
            chosen.setdefault(p.block.suspect, [p.change])
    far = [s for s in place.limits if s not in {place.change.suspect, *chosen}]
    for suspect in far[: 0 if place.late else BEYOND]:
        chosen[suspect] = _sizes(guess(round_.simulations.problem, suspect))
    out = [r for r in before if r.suspect in chosen and r.behind >= FAR * round_.limit]
    for suspect, begun in chosen.items():
        if any(r.suspect == suspect for r in out):
            continue
        tried = [scored for change in begun if (scored := place.quick([change], suspect in same)) is not None]
        quick = max(tried, key=lambda scored: scored.evidence, default=None)
        if quick is None or quick.evidence <= alone.evidence:
            continue
        close = round_.now.evidence - quick.evidence < FAR * round_.limit
        scored = yardstick.refined(quick) if close else quick
        if scored is not None:
            out.append(Rival(suspect, scored, *compare(yardstick.channels, round_.now, scored)))
            if close:
                round_.say(f"  {suspect} for {place.change.suspect}: {-out[-1].behind:+.1f} ± {out[-1].error:.1f}")
    return sorted(out, key=lambda r: r.behind)


def _several(place: _Place) -> Scored | None:
    """The model with several findings in the place of one, where they gain what every one more needs; None elsewhere.

    Two laws at one joint are easily taken for one that does the most of both. In the place of an effort without a law
    they only have to explain as much.
    """
    round_, own = place.round_, place.change.suspect
    lines = _lines(round_, place.alone, [b for b in place.blocks if b.suspect != own])
    several = lines.several(round_.limit)
    numbers = [i for i, b in enumerate(lines.blocks) if any(b is p.block for p in several)]
    if len(several) < 2 or lines.gain(numbers) < CLOSE * place.gain:
        return None
    quick = place.quick([p.change for p in several])
    if quick is None or round_.now.evidence - quick.evidence > FAR * round_.limit:
        return None
    scored = round_.yardstick.refined(quick)
    if scored is None:
        return None
    gain, needs = scored.evidence - round_.now.evidence, round_.limit * (len(several) - 1)
    round_.say(f"  {'; '.join(str(p.block.suspect) for p in several)} for {own}: {gain:+.1f}")
    if own.table is not None:
        return scored if gain > -EQUAL else None
    return scored if gain > max(needs, round_.little(scored)) else None
