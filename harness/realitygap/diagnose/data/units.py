"""The unit of a parameter at its target, and of what an effort depends on there."""

from realitygap.diagnose.data.changes import Suspect
from realitygap.diagnose.data.problem import Problem
from realitygap.robot.drive import CASCADE, PID, SPEED, TORQUE
from realitygap.robot.effects.effect import Parameter
from realitygap.robot.effort_map import VARIABLES

LINEAR = {
    "N·m": "N",
    "N·m·s/rad": "N·s/m",
    "N·m/rad": "N/m",
    "N·m/A": "N/A",
    "duty/rad": "duty/m",
    "rad": "m",
    "rad/s": "m/s",
    "rad/s²": "m/s²",
    "kg·m²": "kg",
    "per 2π": "per 2π m",
}
"""Units of a prismatic joint, in place of those of a revolute one."""


def table_units(problem: Problem, suspect: Suspect) -> tuple[str, list[str]]:
    """The unit of an unnamed effort at its joint, and those of what it depends on."""
    assert suspect.table is not None
    own = unit_there(problem, suspect, suspect.kind.parameters[0])
    return own, [_at_joint(problem, suspect.indices[0], VARIABLES[v]) for v in suspect.table.variables]


def unit_there(problem: Problem, suspect: Suspect, parameter: Parameter) -> str:
    """The unit of a parameter at its target: that of the servo's kind, and of the joint's."""
    unit = parameter.unit
    if suspect.kind.sits_at != "joint" or parameter.name == "phase":  # of a wave, whatever it runs along
        return unit
    j = suspect.indices[0]
    if " or " in unit:
        kind = int(problem.plant.drive["kind"][j])
        other = {CASCADE: "N·m", TORQUE: "", SPEED: "N·m·s/rad"}
        unit = other[kind] if kind in other else unit.split(" or ")[kind == PID]
    return _at_joint(problem, j, unit)


def _at_joint(problem: Problem, joint: int, unit: str) -> str:
    """A unit of revolute joints as it is at a joint."""
    return LINEAR.get(unit, unit) if problem.plant.model.joints[joint].prismatic else unit
