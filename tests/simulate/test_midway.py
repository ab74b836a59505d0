"""A state in the middle of a motion: on the ground or above it, half a step early, and as uncertain as its readings."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from realitygap.robot.drive import neutral_drive
from realitygap.robot.plant import Plant
from realitygap.simulate.midway import Midway, Moving
from realitygap_engines import Ground
from realitygap_engines.model.robot import Link, Model, Sphere

RADIUS, BELOW, H = 0.05, 0.002, 1e-3
FALL = np.array([0.0, 0.0, -9.81])


def ball(ground: Ground | None) -> Plant:
    sphere = Sphere(np.zeros(3), RADIUS)
    model = Model("ball", (Link("ball", 0.4, np.zeros(3), np.eye(3) * 4e-4, (sphere,)),), (), True)
    none = np.zeros(0)
    return Plant(model, neutral_drive(0), ground, none, none, none, np.zeros(2))


def measured(height: float) -> Midway:
    none, small = np.zeros(0), np.full(3, 1e-3)
    place = Moving(np.array([0.1, 0.2, height]), np.array([0.3, 0.0, -0.4]), FALL, small, 10 * small)
    turn = Moving(np.zeros(3), np.array([1.0, 2.0, 3.0]), np.zeros(3), 2 * small, 20 * small)
    return Midway(Moving(none, none, none, none, none), place, turn, np.array([1.0, 0.0, 0.0, 0.0]))


@pytest.mark.parametrize(("ground", "lifted"), [(Ground(0.5), True), (Ground(0.5, 3000.0, 10.0), False), (None, False)])
def test_what_was_measured_below_rigid_ground_begins_on_it(ground: Ground | None, lifted: bool) -> None:
    """Soft ground lets it be there."""
    state = measured(RADIUS - BELOW).state(ball(ground), H)
    assert_allclose(state.base_position, [0.1, 0.2, RADIUS if lifted else RADIUS - BELOW], atol=1e-12)


def test_what_was_measured_above_the_ground_stays_there() -> None:
    state = measured(RADIUS + BELOW).state(ball(Ground(0.5)), H)
    assert_allclose(state.base_position, [0.1, 0.2, RADIUS + BELOW], atol=1e-12)
    assert_allclose(state.base_linear, [0.3, 0.0, -0.4] - 0.5 * H * FALL, atol=1e-12)
    assert_allclose(state.base_angular, [1.0, 2.0, 3.0], atol=1e-12)


def test_other_states_spread_as_the_readings_do() -> None:
    random, middle = np.random.default_rng(0), measured(1.0)
    states = [middle.nudged(random).state(ball(None), H) for _ in range(400)]
    for signal, (place, _) in middle.errors.items():
        if signal == "position":
            continue
        values = np.array([getattr(s, signal) for s in states])
        spread = values.std(axis=0)[1:] if signal == "base_quaternion" else values.std(axis=0)
        assert_allclose(spread, place[: len(spread)], rtol=0.15)
    assert_allclose(np.std([s.base_linear for s in states], axis=0), middle.errors["base_position"][1], rtol=0.15)
    assert_allclose(
        np.std([s.base_angular for s in states], axis=0), 2 * middle.errors["base_quaternion"][1][:3], rtol=0.15
    )
