"""Which known name is offered for one that is not known."""

import pytest
from realitygap.files.errors import did_you_mean, meant_first
from realitygap.robot.effects import WRITABLE
from realitygap.robot.suspicion import QUANTITIES


@pytest.mark.parametrize(
    ("found", "known", "meant"),
    [
        ("coulomb", WRITABLE, "coulomb_friction"),
        ("coulom", WRITABLE, "coulomb_friction"),
        ("colomb_friction", WRITABLE, "coulomb_friction"),
        ("degree", ("rad", "deg", "m", "mm"), "deg"),
        ("servo", ("servos", "robot"), "servos"),
        ("Kp", ("kp", "kd", "ki"), "kp"),
        ("robot.mas", QUANTITIES, "robot.mass"),
        ("gain", ("drive_gain", "gain_law", "mass"), "drive_gain or gain_law"),
    ],
)
def test_a_near_name_is_offered(found: str, known: tuple[str, ...], meant: str) -> None:
    assert did_you_mean(found, known) == f"; did you mean {meant}?"


@pytest.mark.parametrize(
    ("found", "known"),
    [
        ("robot.weight", QUANTITIES),  # as many letters as of robot.inertia are those of robot.
        ("friction", WRITABLE),  # part of seven names
        ("x", ("max", "min")),
        (3, ("rad", "deg")),
    ],
)
def test_a_name_that_nothing_speaks_for_is_not(found: object, known: tuple[str, ...]) -> None:
    assert did_you_mean(found, known) == ""


def test_of_many_names_the_one_that_was_meant_comes_first() -> None:
    assert meant_first("backlsh", ("backlash", "mass"), "known") == "; did you mean backlash? (known: backlash, mass)"
    assert meant_first("magic", ("backlash", "mass"), "known") == "; known: backlash, mass"
