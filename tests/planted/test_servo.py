"""The foreign plant against closed forms: servos, fittings, and what keeps its laws nearly right."""

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parent))  # plain modules, not a package

import friction
import planted
import robots
from chain import GRAVITY
from foreign import simulate
from imperfections import imperfect
from single_servo import ARMATURE, HELD, SWING, free, held, pendulum


@pytest.mark.parametrize("kind", [*robots.ONE_JOINT, *robots.TWO_LINKS])
def test_nearly_right_laws_are_a_few_per_cent_of_what_acts(kind: str) -> None:
    """Along one motion, no law's imperfection takes or gives more than its stated share of what the law gives."""
    robot = robots.BUILDERS[kind](np.random.default_rng(4))
    n = len(robot.joints)
    robot.torque = robot.peak = robot.speed = robot.fastest = np.ones(n)
    plant = robot.plant()
    imperfect(plant, robot, 7)
    drive = plant.drive
    uneven = np.abs(drive["uneven_direction"]) + drive["uneven_angle"]
    assert np.all((uneven >= 0.0399) & (uneven <= 0.1001))
    droop = drive["saturation"] + drive["fading"]
    assert np.all((droop >= 0.0199) & (droop <= 0.0501))
    assert np.all((drive["cable"] >= 0.005 * robot.torque) & (drive["cable"] <= 0.0151 * robot.torque))
    assert np.linalg.norm(plant.chain.gravity) == pytest.approx(9.80665)
    again = robot.plant()
    imperfect(again, robot, 7)
    assert np.array_equal(drive, again.drive)


@pytest.mark.parametrize("drive", [{"coulomb": 0.1, "uneven_direction": 0.08}, {"coulomb": 0.1, "lean": 0.008}])
def test_friction_that_differs_by_direction(drive: dict[str, float]) -> None:
    """Pushed by the same effort either way, a joint gains speed by what friction leaves of it."""
    push, time = 0.3, 0.4
    for side in (1.0, -1.0):
        motion = free(pendulum(gravity=0.0, constant=side * push, **drive), 0.0, time)
        expected = 0.5 * side * (push - 0.1 * (1 + side * 0.08)) / (SWING + ARMATURE) * time**2
        assert motion.link[-1, 0] == pytest.approx(expected, rel=5e-3)


@pytest.mark.parametrize(
    ("drive", "error", "torque"),
    [
        ({"dead_band": 0.06}, 0.1, 5.0 * 0.07),
        ({"dead_band": 0.06}, -0.02, 0.0),
        ({"gain_exponent": 0.7}, 0.3, 5.0 * 0.1 * 3.0**0.7),
        ({"gain_exponent": 0.7}, -0.1, -0.5),
        ({"protection": 0.2, "protection_share": 0.3}, 0.1, 0.5),
        ({"protection": 0.2, "protection_share": 0.3}, 0.3, 5.0 * 0.3 * 0.3),
        ({"real_limit": 0.7}, 0.3, 0.7),
        ({"real_limit": 0.7}, -0.1, -0.5),
    ],
)
def test_what_firmware_makes_of_an_error(drive: dict[str, float], error: float, torque: float) -> None:
    assert held(error, **drive)[1][-1] == pytest.approx(torque, rel=2e-3, abs=1e-9)


def test_torque_lags_behind_its_voltage() -> None:
    time, effort = held(0.2, lag=0.02)
    assert effort == pytest.approx(1.0 - np.exp(-(time + 2e-5) / 0.02), rel=5e-3)


def test_a_servo_of_its_own_rate_answers_at_that_rate() -> None:
    plant = pendulum(**HELD, rate=40.0)
    time = np.arange(0.0, 1.0, 0.005)
    motion = simulate(plant, time, 0.1 * time[:, None], np.ones(len(time)), np.zeros(1), 1.0, settle=0.0)
    changes = motion.time[1:][np.abs(np.diff(motion.effort[:, 0])) > 1e-3]
    assert changes == pytest.approx(np.arange(1, len(changes) + 1) / 40.0, abs=3e-4)
    assert len(changes) == 40


@pytest.mark.parametrize("acceleration", [0.0, 8.0])
def test_a_profile_takes_its_time_to_a_goal(acceleration: float) -> None:
    """way/speed, and speed/acceleration more where it starts and brakes gently."""
    plant = pendulum(**HELD, profile_speed=2.0, profile_acceleration=acceleration)
    at, goals = np.array([0.0, 0.1]), np.array([[0.0], [1.0]])
    motion = simulate(plant, at, goals, np.ones(2), np.zeros(1), 1.2, settle=0.0)
    there = motion.time[np.flatnonzero(motion.effort[:, 0] > 5.0 * 0.9999)[0]]
    assert there - 0.1 == pytest.approx(0.5 + (2.0 / acceleration if acceleration else 0.0), abs=6e-3)
    assert motion.effort[:, 0].max() <= 5.0 * 1.001


def test_a_short_circuit_brakes_by_its_back_emf() -> None:
    push, time = 0.3, 0.05
    plant = pendulum(gravity=0.0, constant=push, torque_constant=2.0, resistance=4.0, braking=0.5)
    damping = 0.5 * 2.0**2 / 4.0
    motion = free(plant, 0.0, time)
    expected = push / damping * (1 - np.exp(-damping * motion.time[-1] / (SWING + ARMATURE)))
    assert motion.velocity[-1, 0] == pytest.approx(expected, rel=2e-3)


@pytest.mark.parametrize(
    ("drive", "rest"),
    [
        ({"spring": 2.0, "spring_rest": 0.3, "constant": 0.2}, 0.3 + 0.1),
        ({"stop_upper": 0.1, "stop_stiffness": 4.0, "constant": 0.2}, 0.1 + 0.05),
        ({"stop_lower": -0.1, "stop_stiffness": 4.0, "constant": -0.2}, -0.1 - 0.05),
    ],
)
def test_a_link_rests_where_what_pulls_beside_its_drive_balances(drive: dict[str, float], rest: float) -> None:
    motion = free(pendulum(gravity=0.0, viscous=0.4, **drive), 0.0, 4.0)
    assert motion.link[-1, 0] == pytest.approx(rest, abs=1e-3)


def test_a_payload_is_carried_at_its_place() -> None:
    robot = robots.BUILDERS["pendulum"](np.random.default_rng(2))
    chain, loaded = robot.plant().chain, robot.plant()
    told = planted.plant("payload", loaded, robot, 0, 1.0, np.random.default_rng(3)).parameters
    q, still = np.array([0.7]), np.zeros(1)
    lever = told["x"] * np.cos(0.7) + told["z"] * np.sin(0.7)  # along x, of a link that is turned about y
    more = loaded.chain.torque(q, still, still) - chain.torque(q, still, still)
    assert more[0] == pytest.approx(-told["mass"] * GRAVITY * lever)
    swing = loaded.chain.torque(q, still, np.ones(1)) - loaded.chain.torque(q, still, still)
    swing -= chain.torque(q, still, np.ones(1)) - chain.torque(q, still, still)
    assert swing[0] == pytest.approx(told["mass"] * (told["x"] ** 2 + told["z"] ** 2))


def test_friction_ripples_with_the_angle() -> None:
    drive = pendulum(coulomb=0.2, friction_ripple=0.5, friction_periods=3.0, friction_phase=0.2).drive[0]
    for q in (-0.4, 0.1, 0.8):
        bound = friction.bound_of(drive, 1.0, 1.0, q, 0.0)
        assert bound == pytest.approx(0.2 * (1 + 0.5 * np.sin(3.0 * q + 0.2)))


def test_a_supply_gives_what_its_chopper_draws() -> None:
    """At rest bus·(1 + R·duty²/resistance) = supply: power in is power out."""
    plant = pendulum(**HELD)
    plant.sag = 0.5
    motion = simulate(plant, np.zeros(1), np.full((1, 1), 0.8), np.ones(1), np.zeros(1), 0.1, settle=0.0)
    bus = 10.0 / (1 + 0.5 * 0.8**2 / 4.0)
    assert motion.effort[-1, 0] == pytest.approx(2.0 / 4.0 * 0.8 * bus, rel=1e-3)


def test_a_saturating_motor_holds_less_by_its_share() -> None:
    """A motor at its duty limit, held at rest: torque = (1 - share)·kt/R·volts at the reference torque."""
    share = 0.04
    assert held(9.0, saturation=share, saturation_torque=5.0)[1][-1] == pytest.approx(5.0 * (1 - share), rel=1e-3)
