"""Moves that let one law take the place of two: one that has a shape to free, and what mends at the same joint what it
lacks without. A spring that rests at another angle than zero is a spring at zero beside a constant effort: with both in
a model the shape gains nothing, and without the effort nothing else stands for it.
"""

from __future__ import annotations

from realitygap.diagnose.data.changes import Change
from realitygap.diagnose.search.grow import with_shape
from realitygap.diagnose.search.round import Round


def merged(round_: Round) -> list[tuple[list[Change], float]]:
    """Models with the shape of a finding freed and another one of its joint left out, and the evidence that each may
    lose: what that finding had to gain.
    """
    accepted, plant, ways = round_.now.fit.changes, round_.simulations.problem.plant, list[tuple[list[Change], float]]()
    for change in accepted:
        shaped = with_shape(plant, change, 1.0) if change.free else change
        for other in accepted if shaped is not change else ():
            if other.free and other is not change and set(other.suspect.joints) == set(change.suspect.joints):
                rest = [c for c in accepted if c is not change and c is not other]
                ways.append(([*rest, shaped], -round_.limit))
    return ways
