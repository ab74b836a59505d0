"""A thrown body: its start is found again from the flight, whatever its shape, and only where it flies."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from realitygap.robot.drive import Array
from realitygap.simulate.flight import Launch, flying, launch, tumble
from realitygap.trace.trace import Trace
from realitygap_engines.model.robot import Link, Model, Sphere
from scipy.spatial.transform import Rotation
from signals import Signals

RATE = 148.0
INERTIA = np.diag([8e-4, 1.4e-3, 2.1e-3])
COM = np.array([0.01, -0.02, 0.005])
START = np.array([0.3, 0.7, -0.5, 0.2]) / np.linalg.norm([0.3, 0.7, -0.5, 0.2])
SPIN = np.array([8.0, -5.0, 12.0])
SPEED = np.array([1.2, -0.4, 0.8])


def matrix(quaternion: Array) -> Rotation:
    return Rotation.from_quat(np.asarray(quaternion)[..., [1, 2, 3, 0]])


def body() -> Model:
    feet = tuple(Sphere(0.05 * np.array([x, y, z]), 1e-3) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1))
    return Model("body", (Link("body", 0.4, COM, INERTIA, feet),), (), True)


def thrown(noise: float = 0.0, bias: float = 0.0, height: float = 0.4) -> Trace:
    """A flight of 0.6 s at most that ends on the ground at z = 0, where the body stays as it is."""
    time = np.arange(0, 0.6, 1 / RATE)
    quaternion = tumble(time, START, SPIN, INERTIA)
    centre = [0.0, 0.0, height] + np.outer(time, SPEED) + 0.5 * np.outer(time**2, [0, 0, -9.81])
    position = centre - matrix(quaternion).apply(COM)
    random = np.random.default_rng(0)
    count = flying(body(), position, quaternion)
    position[count:], quaternion[count:] = position[count], quaternion[count]
    flat = np.zeros((time.size, 0))
    return Trace(
        time + 3.0,
        (),
        position=flat,
        base_position=position + noise * random.standard_normal(position.shape),
        base_quaternion=quaternion,
        base_linear=np.zeros_like(position),
        base_angular=np.tile(SPIN + bias, (time.size, 1)),
    )


def test_a_body_free_of_torque_keeps_momentum_and_energy() -> None:
    time = np.linspace(0, 2, 401)
    quaternion = tumble(time, START, SPIN, INERTIA)
    turns = matrix(quaternion)
    spin = (turns[1:] * turns[:-1].inv()).as_rotvec() / np.diff(time)[:, None]
    middle = Rotation.from_rotvec(spin * np.diff(time)[:, None] / 2) * turns[:-1]
    inside = middle.inv().apply(spin)
    momentum = middle.apply(inside @ INERTIA)
    start = matrix(START)
    first = start.apply(start.inv().apply(SPIN) @ INERTIA)
    assert_allclose(momentum, np.tile(first, (len(momentum), 1)), atol=2e-3 * float(np.linalg.norm(first)))
    assert np.ptp(np.sum(inside @ INERTIA * inside, axis=1)) < 1e-3 * (SPIN @ SPIN) * 2e-3


def launched(trace: Trace) -> Launch:
    found = launch(body(), trace)
    assert found is not None
    return found


@pytest.mark.parametrize("bias", [0.0, 0.4])
def test_the_launch_is_found_again(bias: float) -> None:
    """The recorded velocities are wrong: linear 0, angular `bias` [rad/s] off."""
    found = launched(thrown(bias=bias))
    arm = matrix(START).apply(COM)
    assert_allclose(found.position, [0.0, 0.0, 0.4] - arm, atol=1e-7)
    assert_allclose(found.linear, SPEED - np.cross(SPIN, arm), atol=1e-6)
    assert_allclose(found.angular, SPIN, atol=1e-5)
    assert_allclose((matrix(found.quaternion) * matrix(START).inv()).as_rotvec(), np.zeros(3), atol=1e-6)


def test_noise_is_averaged_over_the_flight() -> None:
    trace = thrown(noise=5e-4)
    first, second = Signals(trace).base_position[:2]
    differenced = (second - first) * RATE
    true = SPEED - np.cross(SPIN, matrix(START).apply(COM))
    assert np.linalg.norm(launched(trace).linear - true) < 0.2 * np.linalg.norm(differenced - true)


@pytest.mark.parametrize("noise", [5e-4, 1e-3])
def test_a_launch_says_by_how_much_the_readings_miss_it(noise: float) -> None:
    far, angle = launched(thrown(noise=noise)).missed
    assert far == pytest.approx(noise, rel=0.25)
    assert angle < 1e-4  # of the integration


def test_what_does_not_fly_has_no_launch() -> None:
    trace = thrown()
    position = Signals(trace).base_position
    held = replace(trace, base_position=np.tile(position[0], (len(trace.time), 1)))
    assert launch(body(), held) is None
    lying = replace(trace, base_position=position * [1, 1, 0])
    assert launch(body(), lying) is None
    assert launch(body(), replace(trace, base_quaternion=None)) is None


def test_the_flight_ends_at_the_ground_or_where_nothing_was_seen() -> None:
    trace = Signals(thrown())
    count = flying(body(), trace.base_position, trace.base_quaternion)
    assert 20 < count < len(trace.time)
    position = trace.base_position.copy()
    position[7] = np.nan
    assert flying(body(), position, trace.base_quaternion) == 7
