"""The foreign plant against closed forms: bodies, friction and transmission."""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parent))  # plain modules, not a package

import robots
from chain import GRAVITY
from foreign import simulate
from plants import Run, command, measure, perform, visibility
from recorder import Sensing
from single_servo import ARMATURE, LENGTH, MASS, SWING, crossings, free, pendulum


def test_small_swing_has_the_period_of_a_compound_pendulum() -> None:
    motion = free(pendulum(), 0.02, 6.0)
    period = np.diff(crossings(motion.time, motion.link[:, 0])).mean()
    assert period == pytest.approx(2 * np.pi * np.sqrt((SWING + ARMATURE) / (MASS * GRAVITY * LENGTH)), rel=2e-4)


def test_dry_friction_takes_the_same_angle_from_every_half_swing() -> None:
    torque = 0.02
    motion = free(pendulum(coulomb=torque), 0.2, 4.0)
    q = motion.link[:, 0]
    turn = np.flatnonzero(np.diff(np.sign(motion.velocity[1:, 0])) != 0)
    peaks = np.abs(q[turn + 1])[:4]
    assert -np.diff(peaks) == pytest.approx(2 * torque / (MASS * GRAVITY * LENGTH), rel=0.03)


def test_a_stuck_joint_stays_within_a_fraction_of_the_encoder_quantum() -> None:
    motion = free(pendulum(coulomb=0.5), 0.3, 3.0)
    assert np.ptp(motion.link[:, 0]) < 0.2 * robots.QUANTUM


def test_beyond_its_friction_a_joint_speeds_up_as_a_free_body() -> None:
    push, torque, time = 0.3, 0.1, 0.5
    motion = free(pendulum(gravity=0.0, coulomb=torque, constant=push), 0.0, time)
    assert motion.link[-1, 0] == pytest.approx(0.5 * (push - torque) / (SWING + ARMATURE) * time**2, rel=5e-3)


def test_load_dependent_friction_takes_its_share_of_what_the_motor_gives() -> None:
    """A motor at its stall limit against a bound of c·τ_t, τ_t = ½·(τ_m + what reaches the link)."""
    motor, share, time = 1.0, 0.2, 0.3
    plant = pendulum(gravity=0.0, kind=1, kp=1e4, effort_limit=motor, load=share)
    plant.drive["bristle"] = motor * share / 3e-4
    motion = simulate(plant, np.zeros(1), np.full((1, 1), 50.0), np.ones(1), np.zeros(1), time, settle=0.0)
    # J_l·a = τ_m − c·τ_t − J_a·a and τ_t = ½·(τ_m + J_l·a)
    total = SWING + ARMATURE + 0.5 * share * SWING
    expected = motor * (1 - 0.5 * share) / total
    assert motion.link[-1, 0] == pytest.approx(0.5 * expected * time**2, rel=5e-3)


def test_compliance_rings_at_the_frequency_of_two_masses() -> None:
    stiffness = 30.0
    motion = free(pendulum(gravity=0.0, stiffness=stiffness, constant=0.2), 0.0, 1.5)
    between = motion.reading[:, 0] - motion.link[:, 0]
    period = np.diff(crossings(motion.time, between - between.mean())).mean()
    assert 2 * np.pi / period == pytest.approx(np.sqrt(stiffness * (1 / ARMATURE + 1 / SWING)), rel=5e-3)


def test_backlash_lets_the_output_fall_by_half_its_width() -> None:
    # friction that even the impact does not overcome: the rotor stays
    plant = pendulum(coulomb=50.0, output_share=0.0, backlash=0.04)
    motion = free(plant, 0.5, 3.0)
    assert 0.5 - motion.link[-1, 0] == pytest.approx(0.02, abs=5e-4)


def test_delay_shifts_the_motion_and_nothing_else() -> None:
    delay, at = 0.01, np.array([0.0, 0.1])
    command = np.array([[0.0], [0.4]])
    quick, late = (
        simulate(pendulum(gain=5.0, delay=d), at, command, np.ones(2), np.zeros(1), 0.6, settle=0.0)
        for d in (0.0, delay)
    )
    shift = round(delay / (quick.time[1] - quick.time[0]))
    assert late.reading[shift:] == pytest.approx(quick.reading[:-shift], abs=1e-9)


def test_the_servo_regulates_what_the_encoder_reads() -> None:
    plant = pendulum(gravity=0.0, gain=5.0, offset=0.1)
    motion = simulate(plant, np.zeros(1), np.full((1, 1), 0.3), np.ones(1), np.full(1, 0.3), 3.0, settle=0.0)
    assert motion.reading[-1, 0] == pytest.approx(0.3, abs=1e-4)
    assert motion.link[-1, 0] == pytest.approx(0.4, abs=1e-4)


@pytest.mark.parametrize("kind", robots.TWO_LINKS)
def test_two_links_without_friction_keep_their_energy(kind: str) -> None:
    robot = robots.BUILDERS[kind](np.random.default_rng(5))
    plant = robot.plant()
    for name in ("coulomb", "static", "viscous", "armature"):
        plant.drive[name] = 0.0
    motion = free(plant, 0.6, 2.0)

    def energy(k: int) -> float:
        q, w, still = motion.link[k], motion.velocity[k], np.zeros(2)
        calm = replace(plant.chain, gravity=np.zeros(3))
        kinetic = 0.5 * w @ np.array([calm.torque(q, still, e) for e in np.eye(2)]) @ w
        # potential energy: the integral of the gravity torque along a straight path from zero
        steps = np.linspace(0, 1, 401)
        work = [plant.chain.torque(s * q, still, still) @ q for s in steps]
        return float(kinetic + np.trapezoid(work, steps))

    values = [energy(k) for k in range(0, len(motion.time), 1000)]
    assert values == pytest.approx([values[0]] * len(values), abs=1e-3 * abs(values[0]))


@pytest.mark.parametrize(("builder", "told"), [("slide", np.inf), ("geared", np.nan)])
def test_a_plant_that_blows_up_is_told_without_a_square_that_is_no_number(builder: str, told: float) -> None:
    """A slide swings by 10^291 m; what turns by as much has no sine."""
    robot = robots.BUILDERS[builder](np.random.default_rng(3))
    sensing, run = Sensing(quantum=robot.quantum), Run("steps", "train", 1, 1.0)
    (clean,) = measure(robot, [run], sensing)
    plant = robot.plant()
    plant.drive["kp"] *= 1e9
    plant.drive["effort_limit"] = 1e300
    robot.bristles(plant)
    motion = perform(plant, run, command(robot, run, sensing))
    np.testing.assert_equal(visibility(robot, plant, motion, clean, sensing), told)
    assert 0.0 <= visibility(robot, robot.plant(), clean, clean, sensing) < 1e-9
