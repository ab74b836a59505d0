"""Which of two explanations is the simpler one."""

from math import isinf

from realitygap.diagnose.candidates.suspects import fitted, neutral, whole
from realitygap.diagnose.data.changes import Suspect
from realitygap.diagnose.data.problem import Problem
from realitygap.robot.effects import EFFECTS


def simpler(problem: Problem, a: Suspect, b: Suspect) -> bool:
    """Whether one suspect has fewer parameters than another, or as many and stands before it in the table of effects.

    An effort that no law explains stands behind every law. On a linear axis without a stated armature, inertia is the
    link's mass.
    """
    order = list(EFFECTS)

    def place(suspect: Suspect) -> tuple[bool, int, float]:
        if suspect.table is not None:
            return True, len(suspect.kind.parameters), 0.0
        joints, drive = problem.plant.model.joints, problem.plant.drive
        linear = suspect.effect == "rotor_inertia" and all(
            joints[i].prismatic and not drive["armature"][i] for i in suspect.indices
        )
        at = order.index("link_mass") + 0.5 if linear else order.index(suspect.effect)
        return False, len(fitted(suspect.kind)), at

    return place(a) < place(b)


def narrower(a: Suspect, b: Suspect) -> bool:
    """Whether one suspect is a special case of another one at the same joints, which says no more of the same law than
    such laws are off by where both do nearly the same.

    Viscous friction is none of the Stribeck effect: of a pendulum whose friction falls with speed, it was apart from
    that by no more than 8 % of what all friction did, and 39 behind.
    """
    return b.effect in a.kind.special_of and a.indices == b.indices


def says_otherwise(finding: Suspect, richer: Suspect) -> bool:
    """Whether a richer law says a finding in other words, as friction by side dry friction: it is nothing else that may
    be there. A load is something else than a heavier link, and may stand beside it.
    """
    return narrower(finding, richer) and richer.kind.rules_out(finding.kind)


def limits(problem: Problem, a: Suspect, b: Suspect) -> bool:
    """Whether one suspect is a limit that is narrower than another one whose values only mean something together. A
    line of torque over speed that ended at 254 rad/s, where no speed came to 10, stood for a limit of the effort.
    """
    hard = any(isinf(v) for v in neutral(problem.plant, a).values())
    return hard and whole(b.kind) and narrower(a, b)
