"""Moves that let one law take the place of two: one that has a shape to free, and what mends at its joints what it
lacks without. Springs that rest at another angle than zero are springs at zero beside constant efforts, or beside a
payload: with all of them in a model the shapes gain nothing, and without the others nothing else stands for those.
"""

from __future__ import annotations

from collections.abc import Sequence

from realitygap.diagnose.data.changes import Change
from realitygap.diagnose.search.grow import with_shape
from realitygap.diagnose.search.round import Round


def merged(round_: Round) -> list[tuple[list[Change], float]]:
    """Models with the shape of a finding freed, or those of all findings of an effect, and another one of their joints
    left out; and the evidence that each may lose: what that finding had to gain.
    """
    accepted, ways = round_.now.fit.changes, list[tuple[list[Change], float]]()
    for alike in _alike(accepted):
        shaped = [with_shape(round_.simulations.problem.plant, c, 1.0) for c in alike]
        joints = {i for c in alike for i in c.suspect.joints}
        rest = [c for c in accepted if c not in alike]
        for other in rest if any(a is not b for a, b in zip(shaped, alike, strict=True)) else ():
            if other.free and joints.issuperset(other.suspect.joints):
                ways.append(([*(c for c in rest if c is not other), *shaped], -round_.limit))
    return ways


def _alike(changes: Sequence[Change]) -> list[list[Change]]:
    """What was fitted, each alone, and together what is of one effect."""
    free = [c for c in changes if c.free]
    of = [[c for c in free if c.suspect.effect == effect] for effect in dict.fromkeys(c.suspect.effect for c in free)]
    return [*([c] for c in free), *(alike for alike in of if len(alike) > 1)]
