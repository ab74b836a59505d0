"""One joint on a bench, for closed forms: a wheel, a pendulum and a slider, and a step of their drives."""

from dataclasses import replace

import numpy as np
import pytest
import realitygap_engines as engines
from realitygap.robot.drive import DC, EFFORT, LOG, PID, STATE, neutral_drive
from realitygap.robot.drive_law import drive_effort
from realitygap.robot.effects.place import place
from realitygap.robot.plant import Plant
from realitygap.scenario.schema import EffectSpec
from realitygap.simulate.commands import Commands
from realitygap.simulate.rollout import rollout
from realitygap.simulate.start import start_state
from realitygap_engines import Physics
from realitygap_engines.model.robot import Array, Joint, Link, Model
from signals import Signals

H = 1e-3
MASS, LENGTH, INERTIA, ARMATURE = 0.5, 0.15, 1e-3, 0.0266
LINK = MASS * LENGTH**2 + INERTIA
TORQUE_CONSTANT, RESISTANCE, SUPPLY = 2.19, 2.96, 15.0

AT_REST = 1e-11
"""A joint that nothing moves stays within this [rad]: rounding."""

everywhere = pytest.mark.parametrize("engine", engines.available())


def solves_exactly(engine: str) -> bool:
    """Whether an engine's step is forward dynamics to rounding, or bodies held together by constraints."""
    return engines.load(engine).capabilities()["forward_dynamics"].level != "no"


def wheel(n: int = 1) -> Plant:
    """n equal arms side by side, each about its own axis along gravity, so that nothing loads it: dc servos."""
    base = Link("base", 1.0, np.zeros(3), np.eye(3) * 1e-3)
    arms = tuple(Link(f"arm{i}", MASS, np.array([LENGTH, 0.0, 0.0]), np.eye(3) * INERTIA) for i in range(n))
    joints = tuple(Joint(f"joint{i}", False, 0, np.eye(4), np.array([0.0, 0.0, 1.0])) for i in range(n))
    drive = neutral_drive(n)
    drive["kind"], drive["gain"], drive["supply"], drive["armature"] = DC, 5.0, SUPPLY, ARMATURE
    drive["torque_constant"], drive["resistance"] = TORQUE_CONSTANT, RESISTANCE
    return Plant(
        Model("wheel", (base, *arms), joints, False), drive, None, np.zeros(n), np.zeros(n), np.ones(n), np.zeros(2)
    )


def pendulum() -> Plant:
    """One arm that hangs at q = 0 and swings about y."""
    plant = wheel()
    links = (plant.model.links[0], replace(plant.model.links[1], com=np.array([0.0, 0.0, -LENGTH])))
    joints = (replace(plant.model.joints[0], axis=np.array([0.0, 1.0, 0.0])),)
    plant.model = replace(plant.model, links=links, joints=joints)
    return plant


def slider(mass: float) -> Plant:
    """A mass on a horizontal guide."""
    plant = wheel()
    links = (plant.model.links[0], Link("arm0", mass, np.zeros(3), np.eye(3) * 1e-3))
    joints = (replace(plant.model.joints[0], prismatic=True, axis=np.array([1.0, 0.0, 0.0])),)
    plant.model = replace(plant.model, links=links, joints=joints)
    return plant


def added(plant: Plant, name: str, target: str = "*", **values: float) -> Plant:
    return place(plant, [EffectSpec(effect=name, target=target, **values)])


def run(
    plant: Plant,
    command: Array | float,
    duration: float = 0.5,
    *,
    engine: str = "mujoco",
    h: float = H,
    velocity: float = 0.0,
    position: float = 0.0,
    joint_effort: bool = False,
) -> Signals:
    """The plant under commands at 1 kHz, linear in between, or under one command."""
    n = len(plant.model.joints)
    value = np.asarray(command, dtype=float)
    value = np.full((2, n), value) if value.ndim == 0 else value.reshape(len(value), -1) * np.ones(n)
    commands = Commands(1e-3 * np.arange(len(value), dtype=np.float64), value, held=False)
    start = start_state(plant, np.full(n, position))
    start.velocity = np.full(n, velocity)
    with engines.load(engine).open(plant.machine(), Physics(h, ground=plant.ground)) as simulation:
        return Signals(rollout(simulation, plant, commands, start, duration, joint_effort=joint_effort).trace)


def one_step(plant: Plant, command: Array, velocity: Array, t: float = 0.0) -> tuple[Array, Array]:
    """The motors' effort, and the voltage they get, at these speeds. Shape (n,)."""
    n = len(plant.model.joints)
    state, log = np.zeros(n, STATE), np.zeros(n, LOG)
    state["velocity"] = velocity
    zeros = [np.zeros(n) for _ in range(5)]
    drive_effort(
        plant.drive, state, command, command, zeros[0], velocity, zeros[1], plant.inertia(), 0.0, t, H, *zeros[2:], log
    )
    return log["motor"] - log["emf"] * velocity, state["bus"].copy()


def effort_servo(plant: Plant) -> Plant:
    """The commands are torques."""
    plant.drive["kind"], plant.drive["meaning"] = PID, EFFORT
    return plant
