"""The missing effort of a followed motion by closed forms: on the joint, by a motor's current, and at rest."""

import numpy as np
import pytest
from one_joint import ARMATURE, LENGTH, LINK, MASS, added
from realitygap.missing.followed import lacking_followed
from realitygap.missing.lacking import Lacking
from realitygap.robot.plant import Plant
from realitygap.simulate.follow import Followed
from realitygap.simulate.start import start_state
from realitygap.trace.trace import Array
from realitygap_engines import GRAVITY
from swings import arm

TIME = np.arange(0.0, 6.0, 0.005)
ANGLE, SPEED, BENT = np.sin(2 * TIME), 2 * np.cos(2 * TIME), -4 * np.sin(2 * TIME)
LOAD = (LINK + ARMATURE) * BENT + MASS * GRAVITY * LENGTH * np.sin(ANGLE)
MORE = 0.2 * np.sign(SPEED)
"""What the motion takes beside the model [N·m]."""
INSIDE = (np.abs(SPEED) > 0.5) & (TIME > 0.3) & (TIME < 5.7)


def lacking(plant: Plant, angle: Array, measured: Array, *, of_joint: bool) -> Lacking:
    followed = Followed(TIME, angle[:, None])
    return lacking_followed(
        "mujoco", plant, followed, start_state(plant, angle[:1]), measured[:, None], of_joint=of_joint
    )


def test_what_a_joint_takes_beside_the_model_acts_against_its_motion() -> None:
    found = lacking(added(arm(), "coulomb_friction", torque=0.3), ANGLE, LOAD + MORE, of_joint=True)
    np.testing.assert_allclose(found.effort[INSIDE, 0], -MORE[INSIDE], atol=0.01)


@pytest.mark.parametrize("heating", [0.0, 0.05])
def test_a_current_tells_it_by_the_factor_and_by_how_warm_the_motor_is(heating: float) -> None:
    """The current of a torque constant of 2 and a factor of 2.6 tells 1.3 times the effort, and more as it warms."""
    plant = added(arm(), "coulomb_friction", torque=0.3)
    plant.drive["torque_constant"], plant.drive["current_factor"], plant.drive["heating"] = 2.0, 2.6, heating
    motor = LOAD + 0.3 * np.sign(SPEED) + MORE
    found = lacking(plant, ANGLE, 1.3 * motor / (1.0 - heating * TIME), of_joint=False)
    np.testing.assert_allclose(found.effort[INSIDE, 0], -MORE[INSIDE], atol=0.015)


@pytest.mark.parametrize("more", [-0.4, -0.2, 0.2, 0.4])
def test_at_rest_nothing_is_missing_that_dry_friction_may_hold(more: float) -> None:
    held = np.full_like(TIME, 0.5)
    plant = added(arm(), "coulomb_friction", torque=0.3)
    found = lacking(plant, held, MASS * GRAVITY * LENGTH * np.sin(held) + more, of_joint=False)
    beyond = more - np.clip(more, -0.3, 0.3)
    np.testing.assert_allclose(found.effort[INSIDE, 0], -beyond, atol=1e-3)


def test_white_noise_of_a_measured_effort_is_its_error() -> None:
    noise = 0.07 * np.random.default_rng(3).normal(size=len(TIME))
    sure, noisy = (lacking(arm(), ANGLE, LOAD + n, of_joint=True).error[INSIDE, 0] for n in (0 * noise, noise))
    assert np.sqrt(np.mean(noisy**2 - sure**2)) == pytest.approx(0.07, rel=0.1)
