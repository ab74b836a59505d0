"""Engines that give accelerations alone, and get their step, stops and ground from the law."""

import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import realitygap_engines as engines
import trees
from realitygap_engines import Diverged, Ground, Physics, State
from realitygap_engines.law.runaway import diverged
from realitygap_engines.model.robot import (
    Array,
    Joint,
    Link,
    Model,
    Sphere,
    axis_rotation,
    frame_along,
    rotation_from_quaternion,
)
from realitygap_engines.model.robot import quaternion_from_rotation as quaternion

H = 1e-3
NAMES = [name for name in ("exudyn", "simbody") if name in engines.available()]
every = pytest.mark.parametrize("name", NAMES)


def arm(lower: float = -np.inf, upper: float = np.inf, friction: float = 0.0) -> Model:
    """A link of 0.01 kg·m² about an axis askew on a fixed base; with gravity off it only turns."""
    base = Link("base", 1.0, np.zeros(3), np.eye(3) * 1e-3)
    link = Link("link", 0.5, np.zeros(3), np.eye(3) * 0.01)
    axis = np.array([0.0, 0.6, -0.8])
    return Model("arm", (base, link), (Joint("hinge", False, 0, np.eye(4), axis, lower, upper),), False)


def turned(name: str, model: Model, start: float, speed: float, efforts: Array, friction: float = 0.0) -> Array:
    """Position of the arm after every step of an effort. Shape (steps,)."""
    position, velocity, base, out = np.zeros(1), np.zeros(1), np.zeros(13), []
    with engines.load(name).open(model, Physics(H)) as simulation:
        simulation.reset(State(np.array([start]), np.array([speed])))
        for effort in efforts:
            simulation.step(np.array([effort]), np.zeros(1), np.array([friction]))
            simulation.read(position, velocity, base)
            out.append(position[0])
    return np.array(out)


@every
@pytest.mark.parametrize("friction", [0.0, 0.1])
@pytest.mark.parametrize(("lower", "upper"), [(-0.5, 0.4), (-np.inf, 0.4), (-0.5, np.inf)])
def test_a_stop_holds_on_its_side_and_lets_go(name: str, lower: float, upper: float, friction: float) -> None:
    for effort, limit in ((0.5, upper), (-0.5, lower)):
        push = np.full(400, effort)
        found = turned(name, arm(lower, upper), 0.0, 0.0, np.concatenate([push, -push[:100]]), friction)
        free = turned(name, arm(), 0.0, 0.0, push, friction)
        if np.isfinite(limit):
            before = np.abs(free) < abs(limit) - 0.02
            np.testing.assert_allclose(found[:400][before], free[before], rtol=0, atol=1e-12)  # not slowed on the way
            np.testing.assert_allclose(found[350:400], limit, rtol=0, atol=1e-6)
            back = (abs(effort) - friction) / 0.01 * H * H * 100 * 101 / 2
            assert abs(found[-1] - limit) == pytest.approx(back, rel=1e-4)
        else:
            np.testing.assert_allclose(found[:400], free, rtol=0, atol=1e-12)


@every
def test_a_joint_that_starts_beyond_its_limit_comes_back_slowly(name: str) -> None:
    """No faster than 0.1 rad/s: it is not thrown, and it arrives."""
    found = turned(name, arm(-0.5, 0.4), 0.5, 0.0, np.zeros(3000))
    assert np.abs(np.diff(found)).max() <= 0.1 * H * (1 + 1e-6)
    assert found[1200] < 0.4


@every
def test_the_last_of_the_way_back_is_shorter_by_a_fifth_in_every_step(name: str) -> None:
    """Of a joint that is pushed beyond either limit, and of a ball below the ground: neither arrives with a jerk."""
    left = 1e-5 * 0.8 ** np.arange(1, 11)
    for limit, side in ((-0.5, -1.0), (0.4, 1.0)):
        found = turned(name, arm(-0.5, 0.4), limit + side * 1e-5, 0.0, np.full(10, side * 0.1))
        np.testing.assert_allclose(side * (found - limit), left, rtol=0, atol=1e-9)
    np.testing.assert_allclose(fall(name, -1e-5, 0.0, 10), -left, rtol=0, atol=1e-8)


def ball(radius: float) -> Model:
    sphere = (Sphere(np.zeros(3), radius),)
    return Model("ball", (Link("ball", 0.5, np.zeros(3), np.eye(3) * 2e-4, sphere),), (), True)


def fall(name: str, height: float, speed: float, steps: int) -> Array:
    """Height of the ball's lowest point over rigid ground after every step. Shape (steps,)."""
    none, base, out = np.zeros(0), np.zeros(13), []
    with engines.load(name).open(ball(0.05), Physics(H, ground=Ground(0.8))) as simulation:
        start = np.array([0.0, 0.0, 0.05 + height])
        simulation.reset(State(none, none, start, base_linear=np.array([0.0, 0.0, speed])))
        for _ in range(steps):
            simulation.step(none, none, none)
            simulation.read(none, none, base)
            out.append(base[2] - 0.05)
    return np.array(out)


@every
@pytest.mark.parametrize("speed", [0.0, -2.0, -8.0])
def test_a_ball_lands_on_the_surface(name: str, speed: float) -> None:
    """Within a micrometre, wherever between two steps it arrives, and stays."""
    for height in np.linspace(0.01, 0.012, 5):
        found = fall(name, height, speed, 200)
        assert found.min() > -1e-6
        assert np.abs(found[100:]).max() < 1e-6


@every
def test_a_body_that_starts_below_the_ground_comes_up_slowly(name: str) -> None:
    found = fall(name, -0.005, 0.0, 200)
    assert np.diff(found).max() <= 0.1 * H * (1 + 1e-3)
    assert abs(found[-1]) < 1e-5


@every
def test_a_base_moves_on_where_its_angles_are_singular(name: str) -> None:
    """A body that lies on its side and turns through a quarter turn of pitch, with an arm that swings on it."""
    arm_model = arm()
    model = replace(arm_model, floating=True)
    still = (0.0, 0.0, 0.0)
    ends = []
    for side in (np.eye(3), axis_rotation(np.array([0.0, 1.0, 0.0]), np.pi / 2)):
        state = State(np.array([0.3]), np.array([1.0]), base_quaternion=quaternion(side))
        state.base_angular, state.base_linear = side @ [0.2, 3.0, -0.5], side @ [0.1, 0.0, 0.3]
        position, velocity, base = np.zeros(1), np.zeros(1), np.zeros(13)
        with engines.load(name).open(model, Physics(H, gravity=still)) as simulation:
            simulation.reset(state)
            for _ in range(1200):  # through the other quarter turn, too
                simulation.step(np.array([0.01]), np.zeros(1), np.zeros(1))
            simulation.read(position, velocity, base)
        ends.append(np.concatenate([position, velocity, side.T @ base[:3], side.T @ base[7:10], side.T @ base[10:]]))
    np.testing.assert_allclose(ends[0], ends[1], rtol=0, atol=1e-10)


@every
def test_a_free_body_turns_by_its_speed_times_time(name: str) -> None:
    """However fast: 6.4 turns in two seconds, a hundredth of a radian in every half step."""
    none, base, spin = np.zeros(0), np.zeros(13), np.array([12.0, -9.6, 12.8])
    with engines.load(name).open(ball(0.05), Physics(H, gravity=(0.0, 0.0, 0.0))) as simulation:
        simulation.reset(State(none, none, np.zeros(3), base_angular=spin))
        for _ in range(2000):
            simulation.step(none, none, none)
        simulation.read(none, none, base)
    expected = axis_rotation(spin / 20.0, 2.0 * 20.0)
    np.testing.assert_allclose(rotation_from_quaternion(base[3:7]), expected, rtol=0, atol=1e-9)


@every
def test_a_blow_up_is_told_at_its_time_since_the_reset_and_its_joint(name: str) -> None:
    """At a speed that no robot has, a million rad/s, and no sooner."""
    one = np.array([0.01 * 1e6 / H])  # gives it in one step
    with engines.load(name).open(arm(), Physics(H)) as simulation:
        for _ in range(2):
            simulation.reset(State(np.zeros(1), np.zeros(1)))
            simulation.step(0.99 * one, np.zeros(1), np.zeros(1))
            with pytest.raises(Diverged, match=r"diverged at 0.0020 s at hinge: velocity runs away"):
                simulation.step(0.02 * one, np.zeros(1), np.zeros(1))


def test_a_blow_up_is_told_at_the_first_joint_where_it_shows_or_at_the_base() -> None:
    model = trees.tree([0, 1, 2])
    for values, where in (([0.0, np.nan, 1e7], "joint1"), ([0.0, 0.0, -1e7], "joint2"), ([0.0, 9e5, 0.0], "base")):
        assert diverged(model, 0.5, np.array(values), "runs away").joint == where


@pytest.mark.parametrize("axis", [(0.0, 0.0, 1.0), (0.0, 0.0, -1.0), (-1.0, 0.0, 0.0), (0.6, -0.64, 0.48)])
def test_a_frame_along_an_axis_is_a_rotation(axis: tuple[float, float, float]) -> None:
    frame = frame_along(np.array(axis))
    np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=1e-15)
    np.testing.assert_allclose(frame[:, 2], axis, atol=0)
    assert np.linalg.det(frame) == pytest.approx(1.0)


THOUSAND = """
import sys
import numpy as np
import realitygap_engines as engines
from realitygap_engines import Ground, Physics
from realitygap_engines.model.robot import Link, Model, Sphere

links = (Link("ball", 0.5, np.zeros(3), np.eye(3) * 2e-4, (Sphere(np.zeros(3), 0.05),)),)
engine, none = engines.load(sys.argv[1]), np.zeros(0)
for i in range(1300):
    with engine.open(Model("ball", links, (), True), Physics(ground=Ground())) as simulation:
        simulation.step(none, none, none)
    if i == 300:
        before = int(open("/proc/self/statm").read().split()[1])
print("pages", int(open("/proc/self/statm").read().split()[1]) - before)
"""


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="reads the size of the process from /proc")
@every
def test_a_thousand_simulations_leave_nothing_behind(name: str, tmp_path: Path) -> None:
    """Neither memory (less than 256 bytes each) nor a word on the console nor a file in the working folder."""
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}
    command = [sys.executable, "-c", THOUSAND, name]
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=True)
    word, pages = done.stdout.split()
    assert (word, done.stderr) == ("pages", "")
    assert int(pages) * os.sysconf("SC_PAGE_SIZE") < 256 * 1000
    assert not list(tmp_path.iterdir())
