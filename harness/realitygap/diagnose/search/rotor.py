"""Moves that part a rotor from its link: inertia that was found at a link may be a rotor's that no one stated.

What lies between the two, as a spring or play, needs a rotor to act on. Beside a link that is made heavier in place of
it, nothing of that kind can be tried: both have to come at once.
"""

from __future__ import annotations

from realitygap.diagnose.candidates.starts import guess, starts
from realitygap.diagnose.data.changes import Change, Suspect, changed, stands_beside
from realitygap.diagnose.fit.responses import single
from realitygap.diagnose.search.round import Round

ROTOR = "rotor_inertia"


def parted(round_: Round) -> list[tuple[list[Change], float]]:
    """Models in which an effect of a link's inertia gives way to a rotor with a spring or play behind it, and the
    evidence that each has to gain.
    """
    problem, accepted = round_.simulations.problem, round_.now.fit.changes
    here = set(round_.criterion.possible(round_.now.fit, round_.everyone))
    waiting = [s for s in round_.everyone if s not in here and single(s)]
    ways = []
    for rotor in [s for s in round_.everyone if s.effect == ROTOR and single(s)]:
        behind = [s for s in waiting if s.indices == rotor.indices]
        for change in [c for c in accepted if behind and _carried(c.suspect, rotor)]:
            rest = [c for c in accepted if c is not change]
            if not stands_beside(rotor, [c.suspect for c in rest]):
                continue
            heavy = guess(problem, rotor).at({"armature": _added(round_, change, rotor)})
            for suspect in behind:
                ways += [([*rest, heavy, start.tries[0]], round_.limit) for start in starts(problem, suspect)]
    return ways


def _carried(suspect: Suspect, rotor: Suspect) -> bool:
    """Whether an effect is of the link that a joint carries."""
    return suspect.kind.sits_at == "link" and suspect.joints == rotor.joints


def _added(round_: Round, change: Change, rotor: Suspect) -> float:
    """The inertia about its joint that a change of a link adds, at least what a rotor usually has [kg·m² or kg]."""
    plant, (joint,) = round_.simulations.problem.plant, rotor.indices
    added = changed(plant, [change], plant).inertia()[joint] - plant.inertia()[joint]
    return max(float(added), guess(round_.simulations.problem, rotor).parameters["armature"])
