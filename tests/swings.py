"""One servo that swings an arm, with something planted that its model lacks: motions, and what readings tell of it."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import realitygap_engines as engines
from one_joint import added, pendulum
from realitygap.missing.driven import lacking_driven
from realitygap.missing.effort import MissingEffort, since_reversal
from realitygap.robot.plant import Plant
from realitygap.simulate.commands import Commands
from realitygap.simulate.rollout import rollout
from realitygap.simulate.start import start_state
from realitygap.trace.trace import Array, Trace
from realitygap_engines import Physics

QUANTUM = 2 * np.pi / 4096
"""Of the encoder [rad]."""
H = 1e-3
Motion = Callable[[Array], Array]
"""The command [rad] over time [s]."""


def chirp(t: Array) -> Array:
    return np.asarray(0.9 * np.sin(2 * np.pi * 0.05 * t**2) + 0.3 * np.sign(np.sin(2 * np.pi * 0.37 * t)))


def sines(t: Array) -> Array:
    return np.asarray(0.8 * np.sin(2 * np.pi * 0.31 * t) + 0.4 * np.sin(2 * np.pi * 0.83 * t + 1.0))


def ramps(t: Array) -> Array:
    return np.asarray(1.2 * np.arcsin(np.sin(2 * np.pi * 0.17 * t)))


def steps(t: Array) -> Array:
    at = np.floor(t / 0.9).astype(int)
    return np.asarray(np.random.default_rng(5).uniform(-1.2, 1.2, at.max() + 1)[at])


MOTIONS: tuple[Motion, ...] = (chirp, sines, ramps, steps)


def arm(load: float = 1.0) -> Plant:
    """The pendulum with a multiple of its mass."""
    plant = pendulum()
    base, link = plant.model.links
    plant.model = replace(plant.model, links=(base, replace(link, mass=load * link.mass)))
    return plant


def mapped(plant: Plant, maps: Sequence[Mapping[str, Any]]) -> Plant:
    """The plant with efforts by table."""
    for one in maps:
        plant = added(plant, "effort_map", **one)
    return plant


def swing(
    true: Plant, motion: Motion, *, engine: str = "mujoco", rate: float = 200.0, lasts: float = 10.0
) -> tuple[Commands, Trace]:
    """What the servo is told, and all that really happens."""
    t = np.arange(0.0, lasts, 1 / rate)
    commands = Commands(t, motion(t)[:, None], held=True)
    with engines.load(engine).open(true.machine(), Physics(H)) as simulation:
        return commands, rollout(simulation, true, commands, start_state(true, np.zeros(1)), lasts).trace


def recovered(plant: Plant, commands: Commands, trace: Trace, *, engine: str = "mujoco") -> MissingEffort:
    """The missing effort of a model along the readings of an encoder, at the times of the commands."""
    position = trace.at(commands.time).position
    assert position is not None
    reading = np.round(position / QUANTUM) * QUANTUM
    start, time = start_state(plant, np.zeros(1)), commands.time
    found = lacking_driven(engine, plant, start, time, reading, commands, None, np.zeros(1), H)
    variables = {
        "angle": found.position,
        "speed": found.velocity,
        "error": commands.value - found.position,
        "load": found.load,
        "reversal": since_reversal(time, found.velocity[:, 0])[:, None],
    }
    return MissingEffort("", engine, None, ("joint0",), (False,), time, found.effort, found.error, variables)
