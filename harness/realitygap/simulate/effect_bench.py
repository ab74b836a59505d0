"""The benches on which an effect shows: one servo that swings an arm, and a block on the ground."""

import math
from dataclasses import dataclass

import numpy as np
import realitygap_engines as engines
from realitygap_engines import Ground, Physics, State
from realitygap_engines.model.robot import Joint, Link, Model, Sphere

from realitygap.robot.drive import DC, PID, neutral_drive
from realitygap.robot.effects.effect import Effect
from realitygap.robot.plant import Plant
from realitygap.simulate.commands import Commands
from realitygap.simulate.rollout import rollout
from realitygap.simulate.start import start_state
from realitygap.trace.trace import Array, Trace

DURATION = 2.0
"""How long the bench's motion takes [s]."""


@dataclass(frozen=True)
class Excitation:
    """What happens on a bench.

    Attributes:
        push: how fast the block starts along x [m/s].
        off: when the servo of the arm is switched off [s].
    """

    push: float = 0.0
    off: float = math.inf


def motion(effect: Effect) -> Excitation:
    """What shows an effect: a block slides to show friction, and sinks where it stands to show softness; an arm is let
    go to show what a servo does that is off.
    """
    return Excitation(
        push=1.0 if effect.name == "ground_friction" else 0.0, off=0.6 if effect.name == "motor_braking" else math.inf
    )


def arm() -> Plant:
    """A dc servo like an MX-106 that swings 0.5 kg at 0.15 m about a horizontal axis; q = 0 hangs down."""
    base = Link("base", 1.0, np.zeros(3), np.eye(3) * 1e-3)
    link = Link("arm", 0.5, np.array([0.0, 0.0, -0.15]), np.eye(3) * 1e-3)
    model = Model("arm", (base, link), (Joint("hinge", False, 0, np.eye(4), np.array([0.0, 1.0, 0.0])),), False)
    drive = neutral_drive(1)
    drive["kind"], drive["gain"], drive["duty_limit"], drive["supply"] = DC, 2.5, 0.9625, 15.0
    drive["torque_constant"], drive["resistance"], drive["armature"] = 2.19, 2.96, 0.0266
    drive["coulomb"] = drive["static"] = 0.05
    drive["viscous"] = 0.02
    return Plant(model, drive, None, np.zeros(1), np.zeros(1), np.ones(1), np.zeros(2))


def pid_arm() -> Plant:
    """The same with a pid servo that holds as well."""
    plant = arm()
    plant.drive["kind"], plant.drive["kp"], plant.drive["kd"] = PID, 28.0, 1.0
    return plant


def block() -> Plant:
    """A flat block of 1.2 kg on four round feet, free to slide."""
    feet = tuple(Sphere(np.array([x, y, -0.01]), 0.01) for x in (-0.1, 0.1) for y in (-0.1, 0.1))
    body = Link("block", 1.2, np.zeros(3), np.diag([4e-3, 4e-3, 8e-3]), feet)
    model = Model("block", (body,), (), True)
    return Plant(model, neutral_drive(0), Ground(0.5), *(np.zeros(0),) * 3, np.zeros(2))


def bench(effect: Effect) -> tuple[Plant, int]:
    """The bench for an effect, without it, and the index of the target there."""
    if effect.sits_at == "ground":
        return block(), 0
    index = 1 if effect.sits_at == "link" else 0
    return (arm() if effect.possible(arm(), index) is None else pid_arm()), index


def command(time: Array) -> Array:
    """A slow and a fast swing, a jump, and a rest, for one joint [rad]. Shape (t, 1)."""
    swing = np.where(time < 1.0, 0.8 * np.sin(np.pi * time), -0.6 * np.sin(4 * np.pi * (time - 1.0)))
    return np.asarray(np.where(time < 1.5, swing, 0.5)[:, None])


def simulate(
    plant: Plant,
    engine: str = "mujoco",
    what: Excitation = Excitation(),
    *,
    duration: float = DURATION,
    timestep: float = 1e-3,
) -> Trace:
    """The bench's motion in one engine: the arm follows `command`, the block is pushed.

    Raises:
        Unsupported: where the engine cannot express the plant.
    """
    time = np.arange(0.0, duration + timestep, 1e-3)
    value = np.where(time[:, None] < what.off, command(time), np.nan)[:, : len(plant.model.joints)]
    start: State = start_state(plant, np.zeros(len(plant.model.joints)))
    if plant.model.floating:
        start.base_linear = np.array([what.push, 0.0, 0.0])
    with engines.load(engine).open(plant.machine(), Physics(timestep, ground=plant.ground)) as simulation:
        return rollout(simulation, plant, Commands(time, value, held=False), start, duration).trace


def planted(effect: Effect, values: dict[str, float] | None = None) -> Plant:
    """The bench with the effect: of these values, or else of its first size."""
    plant, index = bench(effect)
    edited = plant.copy()
    effect.apply(edited, [index], effect.first_size(plant, index) if values is None else values)
    return edited


def signal(effect: Effect, trace: Trace) -> tuple[str, str, Array]:
    """What of a trace shows the effect best: its name, unit and values. Shape (t,)."""
    if effect.sits_at == "ground":
        assert trace.base_position is not None
        what, column = ("travel", 0) if motion(effect).push else ("height", 2)
        return what, "mm", trace.base_position[:, column] * 1e3
    if "position" in effect.signals:
        assert trace.position is not None
        return "position", "°", np.degrees(trace.position[:, 0])
    assert trace.velocity is not None
    return "velocity", "°/s", np.degrees(trace.velocity[:, 0])
