"""The drive law: its order, its stability, and what a servo does at its limits."""

import time
from dataclasses import replace

import numpy as np
import pytest
import realitygap_engines as engines
from numpy.testing import assert_allclose
from realitygap.robot.drive import CASCADE, DC, DRIVE, NONE, PID, neutral_drive
from realitygap.robot.plant import Plant
from realitygap.simulate.commands import Commands
from realitygap.simulate.effect_bench import arm
from realitygap.simulate.rollout import rollout
from realitygap_engines import Physics, State
from realitygap_engines.model.robot import Array, Link
from signals import Signals


def bench(**drive: float) -> Plant:
    plant = arm()
    plant.drive["coulomb"] = plant.drive["static"] = plant.drive["viscous"] = 0.0
    for name, value in drive.items():
        plant.drive[name] = value
    return plant


def light(plant: Plant, inertia: float = 4.5e-4) -> Plant:
    """The arm as the ankle of a humanoid."""
    links = (plant.model.links[0], Link("arm", 0.05, np.zeros(3), np.eye(3) * inertia))
    plant.model = replace(plant.model, links=links)
    return plant


def swing(t: Array) -> Array:
    return 0.6 * np.sin(10.0 * t) * np.minimum(t / 0.2, 1.0)


def run(plant: Plant, h: float = 1e-3, *, command: float | None = None, duration: float = 1.0) -> Signals:
    t = np.arange(0, duration + 1e-9, 1e-4)
    value = swing(t) if command is None else np.full_like(t, command)
    with engines.load("mujoco").open(plant.machine(), Physics(h)) as simulation:
        start = State(np.zeros(1), np.zeros(1))
        return Signals(rollout(simulation, plant, Commands(t, value[:, None], held=False), start, duration).trace)


def error(plant: Plant, h: float, reference: Signals) -> float:
    out = run(plant, h)
    every = round(h / 5e-5)
    return float(np.sqrt(np.mean((out.position - reference.position[::every][: len(out.position)]) ** 2)))


SERVOS = {
    "dc": {},
    "dc with friction": {"viscous": 0.3},
    "pid": {"kind": PID, "kp": 30.0, "kd": 0.8, "ki": 10.0},
    "pid without rotor": {"kind": PID, "kp": 30.0, "kd": 0.8, "armature": 0.0},
    "cascade": {"kind": CASCADE, "gain": 0.05, "kv": 20.0, "kp": 30.0, "armature": 0.0},
    "heating": {"heating": 0.05},
    "saturation": {"saturation": 0.05},
    "ripple": {"ripple": 0.2, "ripple_periods": 9.0},
    "compliance": {"stiffness": 150.0},
    "stiff compliance": {"stiffness": 1e4},
}


@pytest.mark.parametrize("drive", SERVOS.values(), ids=list(SERVOS))
def test_the_drive_is_of_second_order(drive: dict[str, float]) -> None:
    """At half the step the error is a quarter; at 1 ms it is some 1e-5 rad."""
    plant = bench(**drive)
    reference = run(plant, 5e-5)
    coarse, fine = error(plant, 2e-3, reference), error(plant, 1e-3, reference)
    assert fine < 3e-5
    assert coarse / fine > 3.0


@pytest.mark.parametrize(
    ("drive", "bound"),
    [
        ({"coulomb": 0.1, "static": 0.1}, 1e-4),
        ({"coulomb": 0.05, "static": 0.15, "stribeck_velocity": 1.0}, 1e-4),
        ({"load": 0.3}, 2e-4),
        ({"sag_resistance": 0.5}, 1e-4),
        ({"backlash": 0.02}, 2e-4),
        ({"backlash": 0.02, "coulomb": 0.05, "static": 0.05}, 2e-4),
        ({"stiffness": 150.0, "coulomb": 0.1, "static": 0.1}, 1e-4),
        ({"stall_torque": 3.0, "no_load_speed": 4.0}, 1e-4),
    ],
)
def test_what_switches_is_close_to_a_fine_step(drive: dict[str, float], bound: float) -> None:
    """Reversals, impacts and limits happen within a step: less than 0.01° at 1 ms."""
    plant = bench(**drive)
    assert error(plant, 1e-3, run(plant, 5e-5)) < bound


@pytest.mark.parametrize("kd", [0.0, 0.1, 1.0, 5.0])
@pytest.mark.parametrize("limit", [np.inf, 2.0])
def test_a_derivative_term_is_stable_on_light_links(kd: float, limit: float) -> None:
    """h·kd/inertia reaches 11, where an explicit derivative diverges beyond 2, inside the effort limit or at it."""
    plant = light(bench(kind=PID, kp=10.0, kd=kd, effort_limit=limit, armature=0.0, viscous=0.01))
    out = run(plant, command=0.3, duration=2.5)
    assert_allclose(out.position[-1], 0.3, atol=3e-3)
    assert np.abs(out.effort).max() <= limit * (1 + 1e-9)
    assert np.abs(out.velocity[-50:]).max() < 0.05


@pytest.mark.parametrize("drive", [{"backlash": 0.01}, {"backlash": 1e-5}, {"stiffness": 30.0}, {"stiffness": 1e7}])
def test_a_separate_rotor_is_stable_on_light_links(drive: dict[str, float]) -> None:
    plant = light(bench(coulomb=0.05, static=0.05, viscous=0.03, **drive))
    out = run(plant, command=0.3, duration=1.5)
    assert np.abs(out.position).max() < 0.6
    assert_allclose(out.position[-1], 0.3, atol=0.02)


@pytest.mark.parametrize("drive", [{"backlash": 1e-6}, {"stiffness": 1e8}])
def test_a_tight_transmission_is_a_rigid_one(drive: dict[str, float]) -> None:
    plant = bench(coulomb=0.05, static=0.05)
    tight = run(bench(coulomb=0.05, static=0.05, **drive))
    assert_allclose(tight.position, run(plant).position, atol=2e-4)


def test_the_effort_and_velocity_limits_hold() -> None:
    plant = bench(kind=PID, kp=80.0, kd=0.2, effort_limit=1.5, velocity_limit=2.0)
    out = run(plant, command=2.0, duration=1.0)
    assert np.abs(out.effort).max() <= 1.5 + 1e-9
    assert out.velocity.max() <= 2.0 + 0.02


def test_an_integral_does_not_wind_up_at_the_limit() -> None:
    """Held at its limit for a second, a servo leaves it at once when the command comes back."""
    plant = light(bench(kind=PID, kp=10.0, ki=50.0, kd=0.3, effort_limit=0.5, viscous=0.3))
    t = np.arange(0, 3.0, 1e-3)
    value = np.where(t < 1.5, 2.0, 0.2)[:, None]
    with engines.load("mujoco").open(plant.machine(), Physics(1e-3)) as simulation:
        out = Signals(rollout(simulation, plant, Commands(t, value), State(np.zeros(1), np.zeros(1)), 3.0).trace)
    assert out.position.max() < 2.2
    assert_allclose(out.position[-1], 0.2, atol=0.02)


def test_what_the_first_step_has_to_start_up_is_not_in_the_time_it_takes(monkeypatch: pytest.MonkeyPatch) -> None:
    plant = bench()
    with engines.load("dart").open(plant.machine(), Physics(1e-3)) as simulation:
        at_once, waits = simulation.step, iter([0.5])

        def slow(effort: Array, damping: Array, friction: Array) -> None:
            time.sleep(next(waits, 0.0))
            at_once(effort, damping, friction)

        monkeypatch.setattr(simulation, "step", slow)
        still = Commands(np.zeros(1), np.zeros((1, 1)))
        out = rollout(simulation, plant, still, State(np.zeros(1), np.zeros(1)), 0.1)
    assert out.wall < 0.4


@pytest.mark.parametrize("kind", [NONE, DC, PID, CASCADE])
def test_a_neutral_drive_does_nothing(kind: int) -> None:
    plant = arm()
    armature = plant.drive["armature"].copy()
    plant.drive = neutral_drive(1)
    plant.drive["kind"], plant.drive["armature"] = kind, armature
    out = run(plant, duration=0.2)
    assert not out.position.any()
    assert not out.effort.any()


def test_every_parameter_of_the_drive_is_a_number_that_an_effect_can_edit() -> None:
    assert all(DRIVE[name] in (np.dtype(np.float64), np.dtype(np.int64)) for name in DRIVE.names or ())
