"""What could stand in the place of one finding: what would gain most where it is missing, and beside it.

Where it is missing, everything else that is in the model is fitted anew.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from realitygap.diagnose.candidates.starts import guess
from realitygap.diagnose.candidates.suspects import in_shape_of
from realitygap.diagnose.data.changes import Change, Suspect, as_read, clash, stands_beside
from realitygap.diagnose.fit.responses import Block
from realitygap.diagnose.search.alike import alike
from realitygap.diagnose.search.apart import ERRORS, compare, told_apart
from realitygap.diagnose.search.evidence import EQUAL, Scored
from realitygap.diagnose.search.linear import Linear
from realitygap.diagnose.search.round import Round
from realitygap.diagnose.search.simpler import limits, narrower, says_otherwise

ODDS = 3.0
"""Difference in evidence (odds of 20 to 1) below which a rival stays in it anyway."""
LOOKED = 12
"""Suspects whose responses are simulated anew where a finding is missing: those of most predicted gain by their
responses beside it. What does the same as the finding does little more once it is there (a gain beside a risen supply),
or little before (an offset of a joint that sticks): the better one of both counts."""
ROUGHLY = 0.05
"""Of these none with a predicted gain below this share of what the finding gains: on the SO-101 those that came close
had 0.10, 0.38 and 1.0 of it."""
EXCHANGED, LATE = 4, 2
"""Suspects that are tried in the place of a finding: of these, those of most predicted gain. Fewer, of twice as many,
once there is no more time to find a better name for it."""
CLOSE = 0.75
"""Beside the one of most predicted gain, and late that one too, those are tried of which this share of what the finding
does where it is missing is predicted. On the SO-101, of 77 rivals with 0.25 of it or more, the nine that came close
when they were fitted had 0.89 to 1.3 of it."""
BEYOND = 2
"""Suspects far from linear that are tried besides, from their first sizes: those of most predicted gain. They were
simulated at few sizes, and their predicted gain is too small."""
LOOSER = (1.0, 2.0, 4.0)
"""What the first size of a limit is multiplied by, where another fit is near by."""
FAR = 2.0
"""A rival that is further behind in a quick fit than this many times what a name needs is not fitted in full."""


@dataclass(frozen=True)
class Rival:
    """A model with another suspect in the place of a finding, or two of them; `behind` is how much evidence it has
    less, `error` the standard error of that. `same` tells that it makes the same traces, as far as recordings tell, so
    that no more than what was thought beforehand is behind.
    """

    suspect: Suspect
    scored: Scored
    behind: float
    error: float
    beside: Suspect | None = None
    same: bool = False

    @property
    def suspects(self) -> tuple[Suspect, ...]:
        """What stands in the place of the finding."""
        return (self.suspect,) if self.beside is None else (self.suspect, self.beside)

    @property
    def open(self) -> bool:
        """Whether the recordings cannot tell it from the finding, or it is the better one."""
        return self.same or self.behind <= max(ODDS, ERRORS * self.error)

    @property
    def ahead(self) -> bool:
        """Whether it is surely the better one."""
        return -self.behind > max(ODDS, ERRORS * self.error)


@dataclass(frozen=True)
class Place:
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
    def of(cls, round_: Round, change: Change, alone: Scored, late: bool, looked: int) -> Place:
        """What would gain anything there, so many of it simulated anew."""
        rest, gain = [c.suspect for c in alone.fit.changes], round_.now.evidence - alone.evidence

        def fits(suspect: Suspect) -> bool:
            return stands_beside(suspect, rest)

        here = [b for b in round_.blocks if fits(b.suspect)]
        likely = [p for p in lines_at(round_, alone, here).gains() if p.gain > ROUGHLY * gain]
        rough = list(dict.fromkeys(p.block.suspect for p in likely))[:looked]
        known = {b.suspect for b in here}
        beside = [s for s in round_.everyone if s not in known and s != change.suspect and clash(s, change.suspect)]
        far = [] if late else _far(round_, change.suspect)
        tried = [change.suspect, *rough, *(s for s in [*beside, *far] if fits(s))]
        anew = round_.criterion.responses(alone.fit, list(dict.fromkeys(tried)))
        place = cls(round_, change, alone, late, [*anew, *(b for b in here if b.suspect in rough)], gain)
        own = (p.gain for p in place.lines.gains() if p.block.suspect == change.suspect)
        return replace(place, gain=max([gain, *own]))

    @cached_property
    def lines(self) -> Linear:
        """The linearised model of what could stand there."""
        return lines_at(self.round_, self.alone, self.blocks)

    def quick(self, changes: Sequence[Change], beside: bool = False) -> Scored | None:
        """A model with other changes there, fitted quickly; or beside the others as they are with the finding."""
        rest = self.alone.fit.changes
        if beside:
            rest = tuple(c for c in self.round_.now.fit.changes if c.suspect != self.change.suspect)
        return self.round_.adjusted(as_read([*rest, *changes], rest, self.round_.simulations.problem.plant))

    def best(self, begun: Sequence[Change], beside: bool = False) -> Scored | None:
        """The best of quick fits from several first guesses of one suspect; None where none can be simulated."""
        tried = [scored for change in begun if (scored := self.quick([change], beside)) is not None]
        return max(tried, key=lambda scored: scored.evidence, default=None)

    def close(self, quick: Scored) -> bool:
        """Whether a quick fit comes near enough to the finding to be fitted in full."""
        return self.round_.now.evidence - quick.evidence < FAR * self.round_.limit


def lines_at(round_: Round, alone: Scored, blocks: Sequence[Block]) -> Linear:
    """The linearised model where a finding is missing.

    What explains nearly as much leaves as little as the model with the finding, in whose metric it is looked for: where
    the finding is missing, most of what it explains is taken for what no law does.
    """
    return Linear(round_.look.metric, alone.fit.residual, alone.fit.slope, blocks)


def _far(round_: Round, finding: Suspect) -> list[Suspect]:
    """What is far from linear at the joints of a finding, as a limit: what it does beside the finding, which
    does nearly the same, says nothing of what it does in its place.
    """
    whole = dict.fromkeys(b.suspect for b in round_.blocks if b.start.kind == "whole")
    return [s for s in whole if s != finding and set(s.joints) == set(finding.joints)]


def _sizes(limit: Change) -> list[Change]:
    """A limit at several multiples of its first size: from one that is too tight no fit finds back."""
    first = {n: v for n, v in limit.parameters.items() if n in limit.free and np.isfinite(v)}
    return [limit.at({n: looser * v for n, v in first.items()}) for looser in LOOSER]


def rivals_of(place: Place, before: Sequence[Rival]) -> list[Rival]:
    """What explains nearly as much in the place of a finding, the closest first."""
    round_, alone, criterion = place.round_, place.alone, place.round_.criterion
    same = {} if place.late else alike(round_, place.change)
    chosen = {suspect: [change] for suspect, change in same.items()}
    most = len(chosen) + (LATE if place.late else EXCHANGED)
    for p in place.lines.gains():
        worth = p.gain > (CLOSE * place.gain if chosen or place.late else 0.0)
        asked = len(chosen) < most or narrower(p.block.suspect, place.change.suspect)
        if worth and asked and p.block.suspect != place.change.suspect:
            chosen.setdefault(p.block.suspect, [p.change])
    narrow = [s for s in round_.everyone if limits(round_.simulations.problem, s, place.change.suspect)]
    far = [s for s in place.lines.limits() if s not in {place.change.suspect, *chosen}]
    for suspect in [*far[: 0 if place.late else BEYOND], *narrow]:
        chosen[suspect] = _sizes(guess(round_.simulations.problem, suspect))
    out = [r for r in before if r.beside is None and r.suspect in chosen and r.behind >= FAR * round_.limit]
    for suspect, begun in chosen.items():
        if any(r.suspect == suspect for r in out):
            continue
        quick = place.best([in_shape_of(c, place.change) for c in begun], suspect in same)
        if quick is None or quick.evidence <= alone.evidence:
            continue
        close = place.close(quick)
        scored = criterion.refined(quick) if close else quick
        if scored is not None:
            as_one = not says_otherwise(place.change.suspect, suspect) and told_apart(round_.now, scored) < ODDS
            out.append(Rival(suspect, scored, *compare(criterion.channels, round_.now, scored), same=as_one))
            if close:
                round_.say(f"  {suspect} for {place.change.suspect}: {-out[-1].behind:+.1f} ± {out[-1].error:.1f}")
    return sorted(out, key=lambda r: r.behind)


def several_for(place: Place) -> Scored | None:
    """The model with several findings in the place of one, where they gain what every one more needs, and more than
    stretches scatter by; None elsewhere.

    Two laws at one joint are easily taken for one that does the most of both. In the place of an effort without a law
    they only have to explain as much.
    """
    round_, own = place.round_, place.change.suspect
    lines = lines_at(round_, place.alone, [b for b in place.blocks if b.suspect != own])
    several = lines.several(round_.limit)
    numbers = [i for i, b in enumerate(lines.blocks) if any(b is p.block for p in several)]
    if len(several) < 2 or lines.gain(numbers) < CLOSE * place.gain:
        return None
    changes = [p.change for p in several]
    tried = [place.quick(way) for way in [changes, *_said_otherwise(place, changes)]]
    quick = max((q for q in tried if q is not None), key=lambda q: q.evidence, default=None)
    scored = round_.criterion.refined(quick) if quick is not None and place.close(quick) else None
    if scored is None:
        return None
    gain = scored.evidence - round_.now.evidence
    round_.say(f"  {'; '.join(str(c.suspect) for c in scored.fit.changes[-len(several) :])} for {own}: {gain:+.1f}")
    if own.table is not None:
        return scored if gain > -EQUAL else None
    needs = round_.asked(scored, round_.now, round_.limit * (len(several) - 1))
    return scored if gain > max(needs, round_.little(scored)) else None


def _said_otherwise(place: Place, changes: Sequence[Change]) -> list[list[Change]]:
    """The same changes with one of them in the words of an effect that excludes it there, as it says the same and more:
    of friction by side an effort and dry friction would gain as much, and only beside that effort the friction may fall
    with speed, which the linearised model does not tell.
    """
    problem, own, ways = place.round_.simulations.problem, place.change.suspect, []
    for i, change in enumerate(changes):
        for other in place.round_.everyone:
            same = other.kind.rules_out(change.suspect.kind) and other.indices == change.suspect.indices
            if same and other != own:
                ways.append([*changes[:i], guess(problem, other), *changes[i + 1 :]])
    return ways
