"""Moves that let one finding take the place of two of the same law that act at one place.

What a link lacks is easily taken for two things of it that undo most of one another: of a link whose inertia was 3.2
times as large, a load far behind its joint was made and a mass, and no exchange of either one leads back. A load acts
at every joint that carries it: of a SCARA's second arm another centre of mass was made, and a rotor of the first.
"""

from __future__ import annotations

from itertools import combinations

from realitygap.diagnose.data.changes import Suspect, clash
from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.search.alike import alike
from realitygap.diagnose.search.grow import Ways
from realitygap.diagnose.search.round import Round
from realitygap.robot.reach import chain


def one_for_two(round_: Round) -> Ways:
    """Models with what does most of what two findings do together in their place, and the evidence that each may lose:
    what one finding had to gain.
    """
    accepted, problem, ways = round_.now.fit.changes, round_.simulations.problem, []
    for a, b in combinations([c for c in accepted if c.free], 2):
        law, same = a.suspect.kind.law, set(a.suspect.joints) == set(b.suspect.joints)
        if not law or law != b.suspect.kind.law or not (same or weigh_together(problem, a.suspect, b.suspect)):
            continue
        rest = [c for c in accepted if c not in (a, b)]
        for suspect, change in alike(round_, a, b).items():
            if not any(clash(suspect, c.suspect) for c in rest):
                ways.append(([*rest, change], -round_.limit))
    return ways


def weigh_together(problem: Problem, a: Suspect, b: Suspect) -> bool:
    """Whether two are of masses or inertias, each at one joint, and one joint carries the other or is the same."""
    here = {*a.joints, *b.joints}
    inertial = a.kind.law == b.kind.law == "load" and a.kind.changes == b.kind.changes == "model"
    if not inertial or len(a.joints) != 1 or len(b.joints) != 1 or min(here) < 0:
        return False
    return any(chain(problem.plant.model, joint) >= here for joint in here)
