"""What two laws at once could stand in the place of one finding with several values.

Where one hinge swings, a centre of mass that is elsewhere in two directions does what a tilt of the base and another
inertia do. The one finding is named, as it says as much with less; that recordings do not tell it from the two is said.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

from realitygap.diagnose.candidates.starts import sized
from realitygap.diagnose.data.changes import Change, Suspect, stands_beside
from realitygap.diagnose.search.apart import compare
from realitygap.diagnose.search.evidence import Scored
from realitygap.diagnose.search.prune import wald_losses
from realitygap.diagnose.search.rivals import CLOSE, Place, Rival, lines_at

FIRST, SECOND = 4, 3
"""Rivals that something is looked for beside, the closest ones, and what is fitted beside each: what promises most."""


def pairs_for(place: Place, rivals: Sequence[Rival]) -> list[Rival]:
    """Two laws in the place of a finding with two values or more, as far as recordings do not tell them from it, the
    closest first: a rival, and what would gain the rest of what the finding does beside it. Either has to be needed.
    """
    round_, own, out = place.round_, place.change.suspect, list[Rival]()
    if len(sized(place.change)) < 2 or own.table is not None:
        return []
    known = set[frozenset[Suspect]]()
    for first in [r for r in rivals if not r.open][:FIRST]:
        for second in _beside(place, first):
            both = frozenset({first.suspect, second.suspect})
            if both in known:
                continue
            known.add(both)
            quick = round_.adjusted([*first.scored.fit.changes, second], first.scored.fit)
            scored = round_.criterion.refined(quick) if quick is not None and place.close(quick) else None
            if scored is None or not _needed(place, scored, both):
                continue
            pair = Rival(first.suspect, scored, *compare(round_.criterion.channels, round_.now, scored), second.suspect)
            if pair.open:
                round_.say(f"  {first.suspect} and {second.suspect} for {own}: {-pair.behind:+.1f} ± {pair.error:.1f}")
                out.append(pair)
    return sorted(out, key=lambda r: r.behind)


def _beside(place: Place, rival: Rival) -> list[Change]:
    """What would gain most beside a rival, as it answers beside the finding, if both may do what that does."""
    round_, here = place.round_, [c.suspect for c in rival.scored.fit.changes]
    known = [b for b in round_.blocks if stands_beside(b.suspect, [*here, place.change.suspect])]
    gains = lines_at(round_, rival.scored, [b for b in known if b.start.kind != "whole"]).gains()
    whole = round_.now.evidence - place.alone.evidence
    enough = [p for p in gains if p.gain > max(round_.limit, rival.behind - (1.0 - CLOSE) * whole)]
    strongest = dict[Suspect, Change]()
    for p in enough:
        strongest.setdefault(p.block.suspect, p.change)
    return list(strongest.values())[:SECOND]


def _needed(place: Place, scored: Scored, pair: Collection[Suspect]) -> bool:
    """Whether a model needs either of two findings, as far as the linearised model tells."""
    losses = wald_losses(place.round_.simulations.problem, scored)
    return all(losses.get(s, 0.0) >= place.round_.limit for s in pair)
