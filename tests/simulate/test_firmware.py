"""What firmware makes of its command and its error, against what a pencil says."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from one_joint import LENGTH, MASS, RESISTANCE, SUPPLY, TORQUE_CONSTANT, H, added, everywhere, one_step, pendulum, run
from one_joint import wheel as free_wheel
from realitygap.robot.drive import CASCADE, DC, PID
from realitygap.robot.plant import Plant
from realitygap.simulate.commands import Commands, on_steps
from realitygap.simulate.profile import told
from realitygap_engines.model.robot import Array

STIFFNESS = 5.0 * SUPPLY * TORQUE_CONSTANT / RESISTANCE
"""Of a dc servo at rest, while its duty is not at the limit [N·m/rad]."""


def still() -> Plant:
    """A wheel that nothing moves, so that its effort shows the controller alone."""
    plant = free_wheel()
    plant.drive["armature"] = 1e9
    return plant


# dead band


@pytest.mark.parametrize("kind", [DC, PID, CASCADE])
def test_an_error_within_the_dead_band_is_none(kind: int) -> None:
    plant = added(free_wheel(), "dead_band", width=0.04)
    plant.drive["kind"], plant.drive["kp"], plant.drive["kv"] = kind, 8.0, 0.5
    per_error = {DC: STIFFNESS, PID: 8.0, CASCADE: 5.0 * 0.5 * 8.0}[kind]
    for error, seen in ((0.019, 0.0), (-0.019, 0.0), (0.05, 0.03), (-0.12, -0.1)):
        motor, _ = one_step(plant, np.array([error]), np.zeros(1))
        assert_allclose(motor, per_error * seen, atol=1e-12)


@everywhere
def test_a_loaded_joint_rests_half_a_dead_band_further_away(engine: str) -> None:
    plant = added(pendulum(), "dead_band", width=0.04)
    plant.drive["viscous"] = 0.1
    q = run(plant, 0.3, 2.0, engine=engine).position[-1, 0]
    assert_allclose(STIFFNESS * (0.3 - q - 0.02), MASS * 9.81 * LENGTH * np.sin(q), atol=1e-6)


# gain law


@pytest.mark.parametrize("exponent", [0.5, 1.0, 2.0])
def test_the_gain_is_the_nominal_one_at_a_tenth(exponent: float) -> None:
    plant = added(free_wheel(), "gain_law", exponent=exponent)
    for error in (0.1, -0.1, 0.02, -0.12, 0.0):
        motor, _ = one_step(plant, np.array([error]), np.zeros(1))
        expected = STIFFNESS * np.sign(error) * 0.1 * (abs(error) / 0.1) ** exponent
        assert_allclose(motor, expected, rtol=1e-12)


@everywhere
def test_sag_grows_with_the_inverse_of_the_exponent(engine: str) -> None:
    plant = added(added(free_wheel(), "gain_law", exponent=0.5), "constant_effort", effort=-0.4)
    plant.drive["viscous"] = 0.2
    sag = 0.1 * (0.4 / (0.1 * STIFFNESS)) ** 2
    assert_allclose(run(plant, 0.0, 2.0, engine=engine).position[-1, 0], -sag, rtol=1e-5)


# servo rate


@pytest.mark.parametrize("h", [1e-3, 0.5e-3])
def test_an_error_is_held_until_the_next_sample(h: float) -> None:
    """A command that rises by 1 rad/s: the effort climbs a stair each 1/rate."""
    ramp = 1e-3 * np.arange(200, dtype=np.float64)
    out = run(added(still(), "servo_rate", rate=125.0), ramp, 0.19, h=h)
    stair = STIFFNESS * np.floor((out.time + 1e-9) * 125.0) / 125.0
    inside = np.abs((out.time * 125.0 + 0.5) % 1.0 - 0.5) > 0.6 * h * 125.0  # not the steps in which it jumps
    assert inside.mean() > 0.7
    assert_allclose(out.effort[inside, 0], stair[inside], atol=1.01 * STIFFNESS * h)
    late = STIFFNESS * out.time - out.effort[:, 0]
    assert_allclose(late[out.time > 0.02].mean() / STIFFNESS, 0.5 / 125.0, rtol=0.1)


def test_the_rate_acts_continuously() -> None:
    ramp = 0.3 * np.sin(8.0 * 1e-3 * np.arange(500))
    a, b, c = (run(added(free_wheel(), "servo_rate", rate=r), ramp).position[:, 0] for r in (99.0, 99.01, 100.0))
    assert 1e-7 < np.abs(b - a).max() < 1e-5
    assert np.abs(c - a).max() < 1e-3


def test_a_rate_above_the_step_rate_is_none() -> None:
    ramp = 0.3 * np.sin(8.0 * 1e-3 * np.arange(500))
    assert_allclose(run(added(free_wheel(), "servo_rate", rate=2e3), ramp).position, run(free_wheel(), ramp).position)


# command profile


def profile(commands: Commands, speed: float, acceleration: float, steps: int, h: float, delay: float = 0.0) -> Array:
    plant = added(free_wheel(), "command_profile", speed=speed, acceleration=acceleration)
    return told(commands, plant.drive, steps, h, np.array([delay]))[:, 0]


@pytest.mark.parametrize(("speed", "acceleration"), [(4.0, 0.0), (4.0, 50.0), (4.0, 12.0), (0.0, 50.0)])
def test_the_way_to_a_goal_is_a_trapezoid(speed: float, acceleration: float) -> None:
    """1 rad at t = 0.2 s: ramps of speed/acceleration around the cruise, or two halves that meet below the speed."""
    commands = Commands(np.array([0.0, 0.2]), np.array([[0.0], [1.0]]))
    limit, pull = speed or np.inf, acceleration or np.inf
    parts, step = 101, 1e-3  # an odd number of fine steps, whose spans together are a coarse one's
    h = step / parts
    fine = profile(commands, limit, pull, 1500 * parts, h)
    top = min(limit, np.sqrt(pull))
    lasting = 1.0 / top + (top / pull if acceleration else 0.0)
    t = np.arange(len(fine)) * h - 0.2
    ramp = top / pull
    expected = np.select(
        [t <= 0, t < ramp, t < lasting - ramp, t < lasting],
        [0.0, 0.5 * pull * t**2 if acceleration else 0.0, top * (t - ramp / 2), 1 - 0.5 * pull * (lasting - t) ** 2]
        if acceleration
        else [0.0, 0.0, top * t, 1.0],
        1.0,
    )
    assert_allclose(fine, expected, atol=3e-5)
    means = fine[parts // 2 + 1 : -(parts // 2)].reshape(-1, parts).mean(axis=1)
    coarse = profile(commands, limit, pull, 1500, step)[1:]
    assert_allclose(coarse, means, atol=1e-9, err_msg="whatever the step")


@pytest.mark.parametrize("acceleration", [0.0, 80.0])
def test_a_profile_keeps_both_bounds_and_arrives(acceleration: float) -> None:
    rng = np.random.default_rng(3)
    goals = np.append(rng.uniform(-1.0, 1.0, 40), 0.5)
    h = 1e-4
    commands = Commands(0.05 * np.arange(41, dtype=np.float64), goals[:, None])
    out = profile(commands, 5.0, acceleration or np.inf, 30_000, h)
    speed = np.diff(out) / h
    assert np.abs(speed).max() <= 5.0 + 1e-6
    if acceleration:
        assert np.abs(np.diff(speed)).max() / h <= acceleration * (1 + 1e-4)
    assert_allclose(out[-1], 0.5, atol=1e-12)
    assert np.ptp(speed) > 9.0, "both ways"


def test_slow_commands_pass_and_a_delay_is_a_shift() -> None:
    t = np.arange(0.0, 1.0, 1e-3)
    slow = Commands(t, 0.2 * np.sin(3.0 * t)[:, None], held=False)
    assert_allclose(profile(slow, 5.0, np.inf, 900, H)[1:], on_steps(slow, 900, H, np.zeros(1))[1:, 0], atol=1e-4)
    jump = Commands(np.array([0.0, 0.1]), np.array([[0.0], [1.0]]))
    early, late = profile(jump, 4.0, np.inf, 600, H), profile(jump, 4.0, np.inf, 600, H, delay=0.4e-3)
    moving = (early > 0.1) & (early < 0.9)
    assert_allclose((early - late)[moving], 4.0 * 0.4e-3, rtol=1e-9, err_msg="also by a part of a step")


def test_only_the_joint_that_has_a_profile_gets_one_and_off_stays_off() -> None:
    plant = added(free_wheel(2), "command_profile", "joint1", speed=2.0)
    value = np.where(np.arange(10) % 4 == 3, np.nan, 0.7 * (np.arange(10) > 4))[:, None] * np.ones(2)
    commands = Commands(0.02 * np.arange(10, dtype=np.float64), value)
    plain, out = on_steps(commands, 200, H, np.zeros(2)), told(commands, plant.drive, 200, H, np.zeros(2))
    assert np.array_equal(out[:, 0], plain[:, 0], equal_nan=True)
    assert np.array_equal(np.isnan(out), np.isnan(plain))
    assert np.nanmax(np.abs(np.diff(out[:, 1]))) < np.nanmax(np.abs(np.diff(plain[:, 1])))
    never = Commands(np.zeros(1), np.full((1, 2), np.nan))
    assert np.isnan(told(never, plant.drive, 5, H, np.zeros(2))).all()
