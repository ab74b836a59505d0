"""The unit of a parameter where it is fitted: that of the servo's kind, and of the joint's."""

from dataclasses import replace

import pytest
from demo_problem import demo_problem
from realitygap.diagnose.data.changes import Suspect
from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.data.units import table_units, unit_there
from realitygap.robot.drive import CASCADE, DC, PID, SPEED, TORQUE
from realitygap.robot.effects import EFFECTS
from realitygap.robot.effort_map import Table


def elbow(*, slides: bool, kind: int = DC) -> Problem:
    """The demo with another joint for an elbow."""
    problem = demo_problem()
    shoulder, other = problem.plant.model.joints
    plant = problem.plant.copy()
    plant.model = replace(plant.model, joints=(shoulder, replace(other, prismatic=slides)))
    plant.drive["kind"][1] = kind
    return replace(problem, plant=plant)


UNITS = {
    ("coulomb_friction", "torque"): ("N·m", "N"),
    ("coulomb_friction", "onset"): ("rad/s", "m/s"),
    ("viscous_friction", "coefficient"): ("N·m·s/rad", "N·s/m"),
    ("rotor_inertia", "armature"): ("kg·m²", "kg"),
    ("joint_compliance", "stiffness"): ("N·m/rad", "N/m"),
    ("torque_constant", "torque_constant"): ("N·m/A", "N/A"),
    ("command_profile", "acceleration"): ("rad/s²", "m/s²"),
    ("joint_offset", "angle"): ("rad", "m"),
    ("torque_ripple", "periods"): ("per 2π", "per 2π m"),
    ("torque_ripple", "phase"): ("rad", "rad"),
    ("command_delay", "time"): ("s", "s"),
}
GAINS = {
    DC: ("duty/rad", "duty/m"),
    PID: ("N·m/rad", "N/m"),
    CASCADE: ("N·m", "N"),
    TORQUE: ("", ""),
    SPEED: ("N·m·s/rad", "N·s/m"),
}


@pytest.mark.parametrize("slides", [False, True])
def test_a_slide_has_newtons_and_metres_where_a_hinge_has_newton_metres_and_radians(slides: bool) -> None:
    problem = elbow(slides=slides)
    for (effect, name), units in UNITS.items():
        parameter = EFFECTS[effect].parameter(name)
        assert unit_there(problem, Suspect(effect, "elbow", (1,)), parameter) == units[slides], (effect, name)
    mass = Suspect("link_mass", "forearm", (1,))  # of a link, whatever moves it
    assert unit_there(problem, mass, EFFECTS["center_of_mass"].parameter("x")) == "m"


@pytest.mark.parametrize("slides", [False, True])
@pytest.mark.parametrize("kind", GAINS)
def test_a_gain_has_the_unit_of_its_servos_kind(kind: int, slides: bool) -> None:
    gain = EFFECTS["controller_gain"].parameter("gain")
    assert (
        unit_there(elbow(slides=slides, kind=kind), Suspect("controller_gain", "elbow", (1,)), gain)
        == (GAINS[kind][slides])
    )


@pytest.mark.parametrize("slides", [False, True])
def test_an_unnamed_effort_and_what_it_depends_on(slides: bool) -> None:
    table = Table(("speed", "load"), ((-1.0, 1.0), (-1.0, 1.0)))
    told = table_units(elbow(slides=slides), Suspect("effort_map", "elbow", (1,), table=table))
    assert told == (("N", ["m/s", "N"]) if slides else ("N·m", ["rad/s", "N·m"]))
