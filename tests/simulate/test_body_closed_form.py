"""Tilted bases, loads, masses and grounds against what a pencil says, in every engine."""

from dataclasses import replace

import numpy as np
import pytest
import realitygap_engines as engines
from numpy.testing import assert_allclose
from one_joint import (
    INERTIA,
    H,
    added,
    effort_servo,
    everywhere,
    pendulum,
    run,
)
from realitygap.robot.drive import neutral_drive
from realitygap.robot.plant import Plant
from realitygap.simulate.commands import Commands
from realitygap.simulate.rollout import rollout
from realitygap.simulate.start import holding_effort, start_state
from realitygap_engines import Ground, Physics, State
from realitygap_engines.model.robot import Link, Model, Sphere, rotation_from_rpy
from signals import Signals


@everywhere
def test_a_tilted_base_turns_gravity(engine: str) -> None:
    """Right-handed about x, then y: a free pendulum about y hangs at −pitch."""
    plant = added(pendulum(), "base_tilt", "base", roll=0.2, pitch=0.3)
    plant.drive["viscous"] = 0.25
    out = run(plant, np.nan, 4.0, engine=engine)
    gravity = (rotation_from_rpy(0.2, 0, 0) @ rotation_from_rpy(0, 0.3, 0)).T @ np.array([0.0, 0.0, -1.0])
    assert_allclose(out.position[-1, 0], np.arctan2(-gravity[0], -gravity[2]), atol=2e-4)


@everywhere
def test_a_payload_is_a_point_mass_at_its_place_beside_the_link(engine: str) -> None:
    """m·d² in the inertia, m·g·d in what holds the arm still; the link's own mass may change beside it."""
    plant = added(pendulum(), "payload", "arm0", mass=0.7, x=0.05, y=0.02, z=-0.3)
    plant = added(plant, "link_mass", "arm0", mass=0.8)
    own, state = plant.model.links[1], State(np.array([0.4]), np.zeros(1))
    with engines.load(engine).open(plant.machine().with_armature(np.zeros(1)), Physics(H)) as simulation:
        simulation.reset(state)
        mass, bias = float(simulation.mass_matrix()[0, 0]), float(simulation.bias()[0])
    arm = INERTIA + 0.8 * (own.com[0] ** 2 + own.com[2] ** 2)
    assert abs(mass - arm - 0.7 * (0.05**2 + 0.3**2)) < 1e-9
    gravity = 9.81 * (0.8 * own.com + 0.7 * np.array([0.05, 0.02, -0.3]))
    expected = -gravity[0] * np.cos(0.4) - gravity[2] * np.sin(0.4)
    assert abs(bias - expected) < 1e-6
    assert_allclose(holding_effort(plant, np.array([0.4])), [expected], atol=1e-6)


@everywhere
def test_mass_centre_and_inertia_reach_the_mass_matrix_exactly(engine: str) -> None:
    plant = added(pendulum(), "link_mass", "arm0", mass=0.8)
    plant = added(plant, "center_of_mass", "arm0", x=0.03, y=0.02, z=-0.2)
    plant = added(plant, "link_inertia", "arm0", scale=1.7)
    plant = added(plant, "rotor_inertia", armature=0.01)
    with engines.load(engine).open(plant.machine(), Physics(H)) as simulation:
        simulation.reset(State(np.array([0.4]), np.zeros(1)))
        found = simulation.mass_matrix()[0, 0]
        native = engines.load(engine).capabilities()["armature"].level == "native"
    expected = 0.8 * (0.03**2 + 0.2**2) + 1.7 * INERTIA
    assert min(abs(found - expected), abs(found - expected - 0.01)) < 1e-9
    assert not native or abs(found - expected - 0.01) < 1e-9
    # and the motion has all of it: torque over inertia
    plant = effort_servo(plant)
    plant.model = replace(plant.model, joints=(replace(plant.model.joints[0], axis=np.array([0.0, 0.0, 1.0])),))
    upright = 0.8 * (0.03**2 + 0.02**2) + 1.7 * INERTIA
    out = run(plant, 0.1, 0.2, engine=engine)
    assert_allclose(out.velocity[-1, 0], 0.1 / (upright + 0.01) * (out.time[-1] + H / 2), rtol=1e-6)


def block(ground: Ground) -> Plant:
    feet = tuple(Sphere(np.array([x, y, -0.01]), 0.01) for x in (-0.2, 0.2) for y in (-0.2, 0.2))
    model = Model("block", (Link("block", 1.2, np.zeros(3), np.eye(3) * 0.05, feet),), (), True)
    return Plant(model, neutral_drive(0), ground, *(np.zeros(0),) * 3, np.zeros(2))


def thrown(plant: Plant, engine: str, speed: float, duration: float) -> Signals:
    start = start_state(plant, np.zeros(0))
    start.base_linear = np.array([speed, 0.0, 0.0])
    with engines.load(engine).open(plant.machine(), Physics(H, ground=plant.ground)) as simulation:
        return Signals(rollout(simulation, plant, Commands(np.zeros(1), np.zeros((1, 0))), start, duration).trace)


@everywhere
def test_the_ground_friction_is_that_of_the_pair(engine: str) -> None:
    out = thrown(added(block(Ground(0.8)), "ground_friction", "ground", coefficient=0.3), engine, 1.0, 0.6)
    assert_allclose(out.base_position[-1, 0], 1.0 / (2 * 0.3 * 9.81), rtol=0.02)


@everywhere
def test_a_soft_ground_sinks_by_weight_over_stiffness(engine: str) -> None:
    if engines.load(engine).capabilities()["soft_ground"].level == "no":
        pytest.skip(f"{engine} declares that it has no soft ground")
    plant = added(block(Ground(0.8)), "soft_ground", "ground", stiffness=1000.0, damping=20.0)
    out = thrown(plant, engine, 0.0, 1.5)
    depth = 0.02 - out.base_position[:, 2]
    assert_allclose(depth[-1], 1.2 * 9.81 / 4000.0, rtol=0.02)
    rate, decay = np.sqrt(4000.0 / 1.2), 80.0 / 1.2 / 2
    swing = np.sqrt(rate**2 - decay**2)
    t = out.time
    exact = 1.2 * 9.81 / 4000 * (1 - np.exp(-decay * t) * (np.cos(swing * t) + decay / swing * np.sin(swing * t)))
    assert np.abs(depth - exact).max() < 0.1 * 1.2 * 9.81 / 4000.0
