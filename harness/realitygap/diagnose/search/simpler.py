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
    """Whether one suspect says of the same law, at the same joints, with fewer values what another one says: dry
    friction, of one that differs by direction or falls with speed.
    """
    same = a.kind.law == b.kind.law != "" and a.indices == b.indices and a.table is None and b.table is None
    return same and len(fitted(a.kind)) < len(fitted(b.kind))


def limits(problem: Problem, a: Suspect, b: Suspect) -> bool:
    """Whether one suspect is a limit that is narrower than another one whose values only mean something together. A
    line of torque over speed that ended at 254 rad/s, where no speed came to 10, stood for a limit of the effort.
    """
    hard = any(isinf(v) for v in neutral(problem.plant, a).values())
    return hard and whole(b.kind) and narrower(a, b)
