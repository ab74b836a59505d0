"""The likeliest name for what is named after all, in whose place nobody has asked what else could stand."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from realitygap.diagnose.data.changes import Change, Suspect, stands_beside
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.fit.responses import Block
from realitygap.diagnose.judge.plainer import SAME, said_plainly
from realitygap.diagnose.search.apart import compare
from realitygap.diagnose.search.evidence import Scored
from realitygap.diagnose.search.found import Found
from realitygap.diagnose.search.linear import Linear
from realitygap.diagnose.search.rivals import Rival


def likeliest_name(simulations: Simulations, found: Found, suspect: Suspect) -> Found:
    """What was found with the likeliest name in the place of one finding, of what would gain most there as straight
    lines tell, all values fitted anew; the others are its rivals. It keeps its name where the search has asked for a
    better one.

    A geared pendulum whose base is tilted by 6° was left without a name for that, which laws may be off by beside its
    ripple: what straight lines adjusted in its place, and what was named, was a constant effort.
    """
    if found.rivals.get(suspect):
        return found
    alone = found.without[suspect]
    rest = alone.fit.changes
    could = [b for b in found.blocks if b.suspect != suspect and stands_beside(b.suspect, [c.suspect for c in rest])]
    begun = _begun(found, alone, could)
    fitted = (found.criterion.fit([*rest, change], found.best.fit) for change in begun.values())
    others = sorted((o for o in fitted if o is not None), key=lambda scored: -scored.evidence)
    rivals = [Rival(o.fit.changes[-1].suspect, o, *compare(found.criterion.channels, found.best, o)) for o in others]
    if rivals and rivals[0].behind < 0.0:
        return said_plainly(simulations, found, suspect, others)
    return replace(found, rivals={**found.rivals, suspect: rivals})


def _begun(found: Found, alone: Scored, could: Sequence[Block]) -> dict[Suspect, Change]:
    """What would gain most where the finding is missing, as straight lines say, in the metric of the model with it."""
    metric = found.criterion.plain(found.best.fit).metric
    begun = dict[Suspect, Change]()
    for told in Linear(metric, alone.fit.residual, alone.fit.slope, could).gains() if could else ():
        if told.gain > found.limit and len(begun) < SAME:
            begun.setdefault(told.block.suspect, told.change)
    return begun
