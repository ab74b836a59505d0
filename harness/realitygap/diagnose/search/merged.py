"""Moves that let one law take the place of two: one that has a shape to free, and what mends at its joints what it
lacks without. Springs that rest at another angle than zero are springs at zero beside constant efforts, or beside a
payload: with all of them in a model the shapes gain nothing, and without the others nothing else stands for those.
"""

from __future__ import annotations

from realitygap.diagnose.data.changes import Change
from realitygap.diagnose.search.grow import Ways, alike, with_shapes
from realitygap.diagnose.search.round import Round


def merged(round_: Round) -> Ways:
    """Models with the shape of a finding freed, or those of all findings of an effect, and another one of their joints
    left out; and the evidence that each may lose: what that finding had to gain.
    """
    accepted, ways = round_.now.fit.changes, list[tuple[list[Change], float]]()
    together = [of for of in alike(accepted) if len(of) > 1]
    for some in [*([c] for c in accepted if c.free), *together]:
        joints = {i for c in some for i in c.suspect.joints}
        rest = [c for c in accepted if c not in some]
        replaced = [c for c in rest if c.free and joints.issuperset(c.suspect.joints)]
        for shaped in with_shapes(round_.simulations.problem, some) if replaced else ():
            for other in replaced:
                ways.append(([*(c for c in rest if c is not other), *shaped], -round_.limit))
    return ways
