"""Which of two explanations is the simpler one."""

from realitygap.diagnose.candidates.suspects import fitted
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
