"""One step of a drive against its formulas: where friction and ripple are taken, and what a joint's effort is."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from one_joint import ARMATURE, LINK, H, run, wheel
from realitygap.robot.drive import CASCADE, EFFORT, LOG, PID, STATE, neutral_drive
from realitygap.robot.drive_inverse import motor_efforts
from realitygap.robot.drive_law import drive_effort
from realitygap.robot.law.friction import dry_bound
from realitygap.robot.plant import Plant
from signals import Signals

PERIODS, PHASE, ANGLE, AHEAD = 3.0, 0.4, 0.5, 0.2


def of(**drive: float) -> Plant:
    """A wheel that is told efforts."""
    plant = wheel()
    plant.drive["kind"], plant.drive["meaning"] = PID, EFFORT
    for name, value in drive.items():
        plant.drive[name] = value
    return plant


def stepped(plant: Plant, ahead: float = 0.0, speed: float = 0.0) -> tuple[np.ndarray, float, float]:
    """The state, the effort and the dry friction of a first step at an angle, with the rotor so far ahead of it."""
    state, log, zero = np.zeros(1, STATE), np.zeros(1, LOG), np.zeros(1)
    state["rotor"], state["velocity"] = ahead, speed
    effort, damping, friction = (np.zeros(1) for _ in range(3))
    at, w = np.array([ANGLE]), np.array([speed])
    law = effort, damping, friction
    drive_effort(plant.drive, state, zero, zero, at, w, zero, plant.inertia(), 0.0, 0.0, H, *law, log)
    return state, float(effort[0]), float(friction[0])


def test_friction_and_ripple_are_those_of_the_angle() -> None:
    uneven = {"friction_ripple": 0.5, "friction_periods": PERIODS, "friction_phase": PHASE}
    _, _, friction = stepped(of(coulomb=0.3, static=0.3, **uneven))
    assert friction == pytest.approx(0.3 * (1.0 + 0.5 * np.sin(PERIODS * ANGLE + PHASE)))
    _, effort, _ = stepped(of(ripple=0.3, ripple_periods=PERIODS, ripple_phase=PHASE))
    assert effort == pytest.approx(-0.3 * np.sin(PERIODS * ANGLE + PHASE))


def test_behind_a_spring_they_are_those_of_the_rotors_angle() -> None:
    turn = PERIODS * (ANGLE + AHEAD) + PHASE
    uneven = {"friction_ripple": 0.5, "friction_periods": PERIODS, "friction_phase": PHASE}
    ripple = {"ripple": 0.3, "ripple_periods": PERIODS, "ripple_phase": PHASE}
    state, _, _ = stepped(of(coulomb=0.3, static=0.3, stiffness=50.0, **uneven, **ripple), AHEAD)
    assert state["bound"] == pytest.approx(0.3 * (1.0 + 0.5 * np.sin(turn)))
    assert state["momentum"] == pytest.approx(-H * 0.3 * np.sin(turn))


def test_friction_by_side_that_grows_from_rest_leans_to_no_side_at_rest() -> None:
    _, effort, friction = stepped(of(coulomb=0.3, static=0.3, lean=0.1, onset=0.5))
    assert (effort, friction) == (0.0, 0.0)


@pytest.mark.parametrize("speed", [0.0, 0.3, 2.0])
def test_dry_friction_falls_from_rest_over_the_speeds_of_its_two_parts(speed: float) -> None:
    """F = coulomb + (static − coulomb)·exp(−(ω/v)²) + ½·(c + c_s·exp(−(ω/v_l)³))·|τ_m + τ_out|."""
    d = neutral_drive(1)
    for name, value in {"coulomb": 0.2, "static": 0.5, "stribeck_velocity": 0.4, "load": 0.1}.items():
        d[name] = value
    d["load_static"], d["load_velocity"], d["load_exponent"] = 0.3, 0.9, 3.0
    expected = 0.2 + 0.3 * np.exp(-((speed / 0.4) ** 2))
    expected += 0.5 * (0.1 + 0.3 * np.exp(-((speed / 0.9) ** 3))) * abs(2.0 - 3.5)
    assert dry_bound(d[0], speed, 2.0, -3.5) == pytest.approx(expected)


@pytest.mark.parametrize("error", [0.02, 0.1, 0.3])
def test_friction_that_grows_from_rest_is_expected_at_a_velocity_that_is_known_so_well(error: float) -> None:
    """The mean of tanh over velocities that readings leave open, and near rest about what they leave open of it."""
    onset, speed = 0.2, np.linspace(-1.0, 1.0, 21)[:, None]
    drive = of(coulomb=1.0, static=1.0, onset=onset).drive
    zero, out = np.zeros_like(speed), [np.zeros_like(speed) for _ in range(3)]
    motor_efforts(drive, zero, speed, zero, np.full_like(speed, error), zero, *out)
    motor, _, left = out
    open_ = np.tanh((speed + error * np.random.default_rng(0).standard_normal(20000)) / onset)
    assert_allclose(motor[:, 0], open_.mean(axis=1), atol=0.03)
    assert left[10, 0] == pytest.approx(open_[10].std(), rel=0.3)
    leaning = [np.zeros_like(speed) for _ in range(3)]
    drive["lean"] = 0.3
    motor_efforts(drive, zero, speed, zero, np.full_like(speed, error), zero, *leaning)
    assert_allclose(leaning[0] - motor, -0.3 * np.abs(motor), atol=1e-12)


SERVO = {"meaning": 0, "kp": 30.0, "kd": 0.8}


@pytest.mark.parametrize(
    "drive",
    [
        {"coulomb": 0.2, "static": 0.2},
        {"coulomb": 0.1, "static": 0.3, "stribeck_velocity": 1.0, "viscous": 0.1},
        {"load": 0.3, "load_static": 0.2},
        {"coulomb": 0.2, "static": 0.2, "lean": 0.1, "viscous": 0.1, "viscous_asymmetry": 0.5},
        {"coulomb": 0.2, "static": 0.2, "lean": 0.1, "friction_ripple": 0.5, "friction_phase": 0.4},
        {"coulomb": 0.2, "static": 0.2, "onset": 0.5, "viscous": 0.1},
        {"coulomb": 0.2, "static": 0.2, "presliding": 0.01, "lean": 0.05, "viscous": 0.1},
        {"coulomb": 0.2, "static": 0.2, "lean": 0.1, "onset": 0.5, "friction_ripple": 0.5},
    ],
)
def test_the_effort_of_a_joint_is_what_moves_link_and_rotor(drive: dict[str, float]) -> None:
    """Whatever friction took of the motor's: I·a, with the acceleration as positions tell it."""
    t = np.arange(1000) * 1e-3
    out = run(of(**(SERVO | drive)), 0.8 * np.sin(6.0 * t), 0.9, joint_effort=True)
    acceleration = np.diff(out.position[:, 0], n=2) / H**2
    motor = run(of(**(SERVO | drive)), 0.8 * np.sin(6.0 * t), 0.9)
    assert np.abs(motor.effort - out.effort).max() > 0.1, "friction matters"
    size = np.abs(out.effort).max()
    assert_allclose(out.effort[1:-1, 0], (LINK + ARMATURE) * acceleration, rtol=0, atol=0.02 * size)


def test_the_speed_limit_of_a_robots_file_is_that_of_a_pid_servo() -> None:
    """A cascade has its own."""
    cascade = {"kind": CASCADE, "meaning": 0, "gain": 0.05, "kv": 20.0, "kp": 30.0}
    free, limited = (run(of(**cascade, velocity_limit=v), 2.0, 0.5) for v in (np.inf, 0.5))
    assert isinstance(free, Signals)
    assert free.velocity.max() > 1.0
    np.testing.assert_array_equal(limited.position, free.position)
