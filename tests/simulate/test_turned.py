"""What depends on a joint's angle does the same at its readings, wherever the joint's zero is, when it is turned."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from one_joint import added, everywhere, run, wheel
from realitygap.robot.effects import EFFECTS
from realitygap.robot.plant import Plant

ZERO = 0.3
"""Where the joint's zero is [rad]: most of a period of a wave with 5."""
VALUES = {
    "torque_ripple": {"amplitude": 0.5, "periods": 5.0, "phase": 0.4},
    "friction_ripple": {"share": 0.8, "periods": 5.0, "phase": 0.4},
    "cable_spring": {"stiffness": 2.0, "rest": 0.2},
    "joint_stop": {"lower": -0.1, "upper": 0.15, "stiffness": 20.0},
}
"""Values that are seen in a swing of 0.5 rad."""


def test_every_effect_that_turns_is_looked_at() -> None:
    assert {name for name, effect in EFFECTS.items() if effect.turned is not None} == set(VALUES)


@everywhere
@pytest.mark.parametrize("name", VALUES)
def test_turned_values_do_the_same_at_the_readings(name: str, engine: str) -> None:
    turned = EFFECTS[name].turned
    assert turned is not None
    values, rubbing = VALUES[name], added(wheel(), "coulomb_friction", torque=0.2)
    command = 0.5 * np.sin(6.0e-3 * np.arange(500))

    def position(plant: Plant, zero: float) -> np.ndarray:
        return run(plant, command, engine=engine, position=zero).position

    here = position(added(rubbing, name, "*", **values), 0.0)
    there = added(rubbing, name, "*", **(values | turned(values, ZERO)))
    assert_allclose(position(added(there, "joint_offset", angle=ZERO), ZERO), here, atol=1e-6)
    unturned = added(added(rubbing, name, "*", **values), "joint_offset", angle=ZERO)
    assert np.abs(position(unturned, ZERO) - here).max() > 1e-3
