"""What lies between a servo's duty and its motor's torque, against what a pencil says."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from one_joint import ARMATURE, LINK, RESISTANCE, SUPPLY, TORQUE_CONSTANT, H, added, everywhere, one_step, run, wheel
from realitygap.robot.drive import CASCADE, DC, DUTY, PID
from realitygap_engines.model.robot import Array

BACK = TORQUE_CONSTANT**2 / RESISTANCE
"""Damping by back-EMF [N·m·s/rad]."""
STALL = TORQUE_CONSTANT * SUPPLY / RESISTANCE
"""Torque at full duty and rest [N·m]."""

# effort limit


@pytest.mark.parametrize("kind", [DC, PID, CASCADE])
def test_no_servo_gives_more_than_its_real_limit(kind: int) -> None:
    plant = added(wheel(), "effort_limit", effort=1.5)
    plant.drive["kind"], plant.drive["kp"], plant.drive["kv"] = kind, 1e3, 1.0
    for command, speed in ((10.0, 0.0), (-10.0, 0.0), (10.0, 3.0), (-0.1, 30.0)):
        motor, _ = one_step(plant, np.array([command]), np.array([speed]))
        assert_allclose(motor, 1.5 if command > 0 else -1.5, atol=1e-12)
    small, _ = one_step(plant, np.array([1e-4]), np.zeros(1))
    assert abs(small[0]) < 1.5


@everywhere
def test_a_limited_servo_accelerates_at_effort_over_inertia(engine: str) -> None:
    out = run(added(wheel(), "effort_limit", effort=1.0), 10.0, 0.1, engine=engine)
    assert_allclose(out.velocity[:, 0], (out.time + H / 2) / (LINK + ARMATURE), rtol=1e-5)


def test_protection_gives_a_share_beyond_an_error() -> None:
    plant = added(wheel(), "effort_limit", beyond=0.1, share=0.25)
    gain = 5.0 * STALL
    for error, expected in ((0.099, 0.099 * gain), (0.101, 0.25 * 0.101 * gain), (-0.3, -0.25 * 0.3 * gain)):
        motor, _ = one_step(plant, np.array([error]), np.zeros(1))
        assert_allclose(motor, expected, rtol=1e-12)


# motor braking


@everywhere
@pytest.mark.parametrize("share", [0.0, 0.3, 1.0])
def test_a_servo_that_is_off_brakes_by_its_share_of_a_short_circuit(share: float, engine: str) -> None:
    out = run(added(wheel(), "motor_braking", share=share), np.nan, 0.2, engine=engine, velocity=2.0)
    rate = share * BACK / (LINK + ARMATURE)
    exact = 2.0 * np.exp(-rate * out.time) * 0.5 * (1 + np.exp(-rate * H))
    assert_allclose(out.velocity[:, 0], exact, rtol=1e-5)
    assert_allclose(out.effort[:, 0], -share * BACK * out.velocity[:, 0], rtol=1e-2, atol=1e-12)


def test_braking_ends_when_the_servo_is_switched_on() -> None:
    plant = added(wheel(), "motor_braking", share=1.0)
    on, _ = one_step(plant, np.zeros(1), np.zeros(1))
    without, _ = one_step(wheel(), np.zeros(1), np.zeros(1))
    assert_allclose(on, without)


# current lag


@pytest.mark.parametrize("lag", [0.3e-3, 5e-3, 0.05])
def test_the_torque_follows_the_duty_exponentially(lag: float) -> None:
    """A wheel that nothing moves: the mean over every step of 1 − exp(−t/lag), whatever the step."""
    plant = added(wheel(), "current_lag", time=lag)
    plant.drive["meaning"], plant.drive["armature"] = DUTY, 1e9
    duty = np.where(np.arange(400) < 100, 0.0, 1.0)
    out = run(plant, duty, 0.39)
    begin = int(np.argmax(out.command[:, 0] > 0.5)) + 1  # from here on the duty is whole
    n = np.arange(len(out.time) - begin)
    x = H / lag
    missing = STALL - out.effort[begin:, 0]
    assert_allclose(missing, missing[0] * np.exp(-n * x), atol=1e-9 * STALL)
    assert_allclose(out.effort[-1, 0], STALL * (1 - np.exp(-(out.time[-1] - 0.0995) / lag)), rtol=0.02)


@everywhere
@pytest.mark.parametrize("lag", [2e-3, 20e-3])
def test_a_winding_and_a_wheel_are_a_system_of_second_order(lag: float, engine: str) -> None:
    """lag·ω'' + ω' + b/I·ω = 0 of a wheel whose servo gives no volts: it rings where 4·lag·b/I > 1."""
    plant = added(wheel(), "current_lag", time=lag)
    plant.drive["meaning"] = DUTY
    out = run(plant, 0.0, 0.3, engine=engine, velocity=2.0)
    rate = BACK / (LINK + ARMATURE)
    roots = np.roots([lag, 1.0, rate]).astype(complex)
    weights = np.linalg.solve(np.array([[1.0, 1.0], roots]), np.array([2.0, -2.0 * rate], dtype=complex))
    ends = np.append(out.time, out.time[-1] + H)  # a reported velocity is the mean of a step's ends
    exact: Array = (weights[:, None] * np.exp(roots[:, None] * ends)).sum(axis=0).real
    assert_allclose(out.velocity[:, 0], 0.5 * (exact[:-1] + exact[1:]), atol=4e-3)


def test_a_simulation_begins_in_the_steady_state() -> None:
    plant = added(wheel(), "current_lag", time=0.05)
    motor, _ = one_step(plant, np.array([0.1]), np.zeros(1))
    assert_allclose(motor, 0.1 * 5.0 * STALL)
