"""A joint that rests under a load begins with its play closed on the loaded side, and its spring twisted."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from one_joint import ARMATURE, LENGTH, MASS, added, effort_servo, everywhere, pendulum, run, wheel
from realitygap.simulate.commands import Commands
from realitygap.simulate.start import resting_twist

WEIGHT = MASS * 9.81 * LENGTH
PLAY = 0.04


def _at(value: float) -> Commands:
    return Commands(np.zeros(1), np.array([[value]]))


@pytest.mark.parametrize("angle", [0.5, -0.5])
def test_the_rotor_is_ahead_on_the_side_that_carries(angle: float) -> None:
    """A pendulum that is held at an angle pulls back to zero: its rotor lies on the far side."""
    loose = added(pendulum(), "backlash", angle=PLAY)
    assert_allclose(resting_twist(loose, _at(angle), np.array([angle])), np.sign(angle) * PLAY / 2)
    soft = added(pendulum(), "joint_compliance", stiffness=20.0)
    assert_allclose(resting_twist(soft, _at(angle), np.array([angle])), WEIGHT * np.sin(angle) / 20.0, rtol=1e-4)


def test_what_nothing_holds_or_loads_begins_in_the_middle() -> None:
    loose = added(pendulum(), "backlash", angle=PLAY)
    away = np.array([0.5])
    assert resting_twist(loose, _at(np.nan), away) == 0.0, "the servo is off"
    assert resting_twist(added(effort_servo(pendulum()), "backlash", angle=PLAY), _at(0.0), away) == 0.0
    assert resting_twist(loose, _at(0.0), np.zeros(1)) == 0.0, "it hangs straight down"
    assert resting_twist(added(wheel(), "backlash", angle=PLAY), _at(0.0), away) == 0.0, "no load"
    assert resting_twist(pendulum(), _at(0.5), away) == 0.0, "no play"
    rigid = replace(loose, drive=loose.drive.copy())
    rigid.drive["armature"] = 0.0
    assert ARMATURE > 0.0
    assert resting_twist(rigid, _at(0.5), away) == 0.0, "no rotor"


@everywhere
def test_a_loaded_joint_with_play_does_not_fall_through_it(engine: str) -> None:
    """It sags as one without play does, from where it was measured."""
    sagged = [
        run(added(pendulum(), "backlash", angle=play), 0.5, 0.5, engine=engine, position=0.5) for play in (0.0, PLAY)
    ]
    without, with_ = (out.position[:, 0] for out in sagged)
    assert np.abs(with_ - without).max() < 0.02 * PLAY


@everywhere
def test_a_loaded_spring_is_at_rest_where_it_was_measured(engine: str) -> None:
    """The encoder is on the rotor: its reading and that of a rigid joint begin alike, and neither rings."""
    plant = added(pendulum(), "joint_compliance", stiffness=200.0)
    link = 0.5 - float(resting_twist(plant, _at(0.5), np.array([0.5]))[0])
    soft = run(plant, 0.5, 0.5, engine=engine, position=link)
    stiff = run(pendulum(), 0.5, 0.5, engine=engine, position=0.5)
    assert np.abs(soft.position - stiff.position).max() < 2e-3
