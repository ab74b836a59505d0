"""Moves that let one law take the place of two: one that has a shape to free, and what mends at its joints what it
lacks without. Springs that rest at another angle than zero are springs at zero beside constant efforts, or beside a
payload: with all of them in a model the shapes gain nothing, and without the others nothing else stands for those.
Friction that builds up over an angle is friction beside a spring.
"""

from __future__ import annotations

from realitygap.diagnose.candidates.suspects import building_up, gives_way
from realitygap.diagnose.data.changes import Change
from realitygap.diagnose.search.grow import Ways, alike, with_shape
from realitygap.diagnose.search.round import Round


def merged(round_: Round) -> Ways:
    """Models with the shape of a finding freed, or those of all findings of an effect, and another one of their joints
    left out; and the evidence that each may lose: what that finding had to gain. What gives way may do so at more
    joints than friction was found at.
    """
    accepted, plant = round_.now.fit.changes, round_.simulations.problem.plant
    together = [of for of in alike(accepted) if len(of) > 1]
    ways = list[tuple[list[Change], float]]()
    for some in [*([c] for c in accepted if c.free), *together]:
        joints = {i for c in some for i in c.suspect.joints}
        shaped = [with_shape(plant, c, 1.0) for c in some]
        building = [b for c in some if (b := building_up(plant, c)) is not None]
        for other in (c for c in accepted if c not in some and c.free):
            rest = [c for c in accepted if c not in some and c is not other]
            within, apart = joints.issuperset(other.suspect.joints), joints.isdisjoint(other.suspect.joints)
            if within and any(new is not old for new, old in zip(shaped, some, strict=True)):
                ways.append(([*rest, *shaped], -round_.limit))
            if not apart and len(building) == len(some) and gives_way(other.suspect):
                ways.append(([*rest, *building], -round_.limit))
    return ways
