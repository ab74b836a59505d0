"""The measured state at a moment: that of a motion that is known, with the error that readings leave of it."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from demo_problem import demo_problem
from numpy.testing import assert_allclose
from realitygap.diagnose.data.case import Case
from realitygap.diagnose.data.changes import Change, Suspect
from realitygap.diagnose.data.moment import Moments
from realitygap.diagnose.data.windows import cut
from realitygap.diagnose.data.worker import Query, answer
from realitygap.trace.trace import Array, Trace
from realitygap_engines import GRAVITY
from realitygap_engines.model.robot import Joint, Link, Model
from scipy.spatial.transform import Rotation
from signals import there

TIME = np.arange(60, dtype=np.float64) / 100.0
SPEED, PULL, TURN = np.array([0.8, -0.5, 2.0]), np.array([0.4, 1.0, -2.0]), np.array([1.5, -2.0, 3.0])
FAR, ANGLE = 1e-3, 2e-3
"""Noise of a base's place [m] and of its orientation about each axis [rad]."""


def body(joints: int) -> Model:
    """Something in the air, of one link or with a limb."""
    links = tuple(Link(f"l{k}", 1.0, np.zeros(3), np.eye(3) * 2e-3) for k in range(1 + joints))
    return Model("b", links, tuple(Joint("j", False, 0, np.eye(4), np.eye(3)[0]) for _ in range(joints)), True)


def moving(model: Model, pull: Array, noise: float = 0.0, seed: int = 0) -> Moments:
    """A base under an acceleration that turns evenly about an axis of the world, as it was read."""
    random, n = np.random.default_rng(seed), len(TIME)
    t = TIME[:, None]
    place = 2.0 + SPEED * t + 0.5 * pull * t**2 + noise * FAR * random.standard_normal((n, 3))
    turns = Rotation.from_rotvec(TURN * t) * Rotation.from_rotvec([0.4, -0.9, 0.3])
    turns = Rotation.from_rotvec(noise * ANGLE * random.standard_normal((n, 3))) * turns
    none = np.zeros((n, len(model.joints)))
    quaternion = np.asarray(turns.as_quat(scalar_first=True))
    quaternion *= np.where(np.sum(quaternion * quaternion[:1], axis=1, keepdims=True) < 0, -1.0, 1.0)
    trace = Trace(TIME, tuple(model.joint_names), position=none, base_position=place, base_quaternion=quaternion)
    trace = replace(trace, base_angular=np.tile(1.05 * TURN, (n, 1)))
    plant: Any = type("Plant", (), {"loaded": lambda _: model})()
    experiment: Any = type("Experiment", (), {"plant": plant})()
    told = {"base_position": np.full(3, FAR), "base_quaternion": np.full(4, ANGLE / 2 * np.sqrt(3) / 2)}
    return Moments(Case("toss", experiment, trace, "train", told, 1))


@pytest.mark.parametrize("k", [0, 20, 59])
def test_a_base_is_where_it_was_and_goes_and_turns_as_it_did(k: int) -> None:
    found, t = moving(body(1), PULL).at(k), TIME[k]
    place, turn = there(found.place), there(found.turn)
    assert_allclose(place.position, 2.0 + SPEED * t + 0.5 * PULL * t**2, atol=1e-9)
    assert_allclose(place.velocity, SPEED + PULL * t, atol=1e-9)
    assert_allclose(place.acceleration, PULL, atol=1e-7)
    assert_allclose(turn.velocity, TURN, atol=1e-6)
    assert_allclose(turn.position, 0.0, atol=1e-9)


def test_a_body_that_flies_falls() -> None:
    fall = np.array([0.0, 0.0, -GRAVITY])
    found = moving(body(0), fall).at(0)
    place, turn = there(found.place), there(found.turn)
    assert_allclose(place.velocity, SPEED, atol=1e-3)
    assert_allclose(place.acceleration, fall)
    assert_allclose(turn.velocity, TURN, atol=1e-2)


@pytest.mark.parametrize(("joints", "pull", "most"), [(1, PULL, 1.35), (0, np.array([0.0, 0.0, -GRAVITY]), 12.0)])
def test_the_errors_that_are_told_are_those_that_are_made(joints: int, pull: Array, most: float) -> None:
    """Of 200 times the same motion. What a flight misses its readings by may last: there they are more than noise
    makes, as far as of a line at its end (2σ and √12·σ over its length).
    """
    made: dict[str, list[Array]] = {"place": [], "speed": [], "rate": []}
    told: dict[str, list[Array]] = {"place": [], "speed": [], "rate": []}
    for seed in range(200):
        found = moving(body(joints), pull, 1.0, seed).at(0)
        place, turn = there(found.place), there(found.turn)
        if not joints:
            ratio = place.velocity_error / place.position_error
            assert_allclose(ratio, np.sqrt(12.0) / 2.0 / (TIME[-1] - TIME[0]))
        made["place"].append(place.position - 2.0)
        made["speed"].append(place.velocity - SPEED)
        made["rate"].append(turn.velocity - TURN)
        for name, error in zip(told, (place.position_error, place.velocity_error, turn.velocity_error), strict=True):
            told[name].append(error)
    for name, errors in made.items():
        real, said = (float(np.sqrt(np.mean(np.square(v)))) for v in (errors, told[name]))
        assert 0.65 * real < said < most * real, name


@pytest.mark.parametrize("delay", [0.0, 0.1])
def test_windows_of_the_true_model_go_on_as_the_whole_motion(delay: float) -> None:
    """Every one gets the commands of its own time, and those that are still on their way when it begins."""
    problem = demo_problem()
    i = next(k for k, c in enumerate(problem.cases) if "sines" in c.name)
    everywhere = Suspect("command_delay", "*", (0, 1))
    late = (Change(everywhere, (("time", delay),)),)
    signals = there(answer(problem, Query(late, i, "mujoco")))
    case = replace(problem.cases[i], measured=replace(problem.cases[i].measured, **signals))  # type: ignore[arg-type]
    parted = cut(case, 0.5)
    assert len(parted.windows) > 4
    again = there(answer(replace(problem, cases=(parted,)), Query(late, 0, "mujoco")))
    off = np.abs(again["position"] - signals["position"])
    assert np.sqrt(np.mean(off**2)) < 2e-3
    begins = np.searchsorted(case.measured.time, [w.begin for w in parted.windows])
    assert off[begins].max() < 1e-3, "each is at its measured state where it begins"
