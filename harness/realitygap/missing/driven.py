"""The missing effort of joints that servos drive, by a smoother over the model's own dynamics.

Led along the measured motion, the model's drives give known efforts, and those known accelerations. What these make
over time is the expected motion. The readings differ from it by what the missing effort makes: its acceleration is what
the smoother of `simulate.smooth` tells of the difference, with a standard error, and the inertia turns it into an
effort. So jumps of a command, which the model knows, are not smeared, and nothing is differentiated twice.
"""

from dataclasses import dataclass

import numpy as np
import realitygap_engines as engines
from realitygap_engines import Physics, State
from scipy.interpolate import CubicHermiteSpline, make_interp_spline

from realitygap.missing.lacking import Lacking
from realitygap.recording.quantum import quantum
from realitygap.robot.plant import Plant
from realitygap.simulate.commands import Commands, edges_of
from realitygap.simulate.inertia import inertias, times
from realitygap.simulate.led import Led, lead
from realitygap.simulate.profile import told
from realitygap.simulate.smooth import smooth
from realitygap.trace.trace import Array

PASSES = 2
"""First along the readings' own smooth motion; then along the one that the model's efforts and the readings make."""


@dataclass(frozen=True)
class Machine:
    """The rigid robot at every stamp of a motion: inertia with rotors (t, n, n), of links alone, and bias (t, n)."""

    inertia: Array
    links: Array
    bias: Array


def lacking_driven(
    engine: str,
    plant: Plant,
    start: State,
    time: Array,
    reading: Array,
    commands: Commands,
    supply: tuple[Array, Array] | None,
    integral: Array,
    h: float,
) -> Lacking:
    """The missing effort along readings (t, n) at times (t,) on the simulation's clock [s], with steps of h [s].

    Raises:
        Unsupported: where the engine cannot express the plant.
    """
    steps = int(np.ceil(time[-1] / h)) + 1
    grid = np.arange(steps, dtype=np.float64) * h
    command = told(commands, plant.drive, steps, h, plant.delay)
    volts = np.zeros(steps) if supply is None else np.interp(grid, *supply)
    motion = smooth(time, reading)
    position, velocity, acceleration = motion.value
    error, unsure = motion.error, motion.error[0]
    for _ in range(PASSES):
        machine = _machine(engine, plant, start, position, velocity)
        need = _on(time, machine.bias + times(machine.inertia, acceleration), grid)
        known = [_led(plant, time, p, v, error[1], need, command, volts, grid, h, integral) for p, v in (
            (position, velocity), (position + unsure, velocity), (position, velocity + error[1]))]  # fmt: skip
        expected = _expected(time, machine, known[0], grid, h)
        rest = smooth(time, reading, around=expected[0])
        position, velocity, acceleration = expected + rest.value
        error, unsure = rest.error, np.hypot(rest.error[0], _rounding(reading, velocity, rest.bandwidth))
    missing = times(machine.inertia, rest.value[2])
    spread = times(machine.inertia**2, rest.error[2] ** 2) + _unsure(known, time, grid)
    load = machine.bias + times(machine.links, acceleration)
    return Lacking(position, velocity, missing, np.sqrt(spread), load)


def _rounding(reading: Array, velocity: Array, bandwidth: Array) -> Array:
    """What rounding leaves open of positions that are smoothed over one over the bandwidth [Hz]. Shape (t, n).

    Readings of one count have one error, however many there are: what averages out is the number of counts passed.
    """
    count = quantum(reading)
    passed = np.abs(velocity) / np.maximum(bandwidth * count, 1e-300)
    return np.asarray(count / np.sqrt(12.0 * (1.0 + np.where(count > 0, passed, 0.0))))


def _machine(engine: str, plant: Plant, start: State, position: Array, velocity: Array) -> Machine:
    model = plant.machine().with_armature(np.zeros(position.shape[1]))
    with engines.load(engine).open(model, Physics()) as simulation:
        bias = simulation.inverse_dynamics(start, position + plant.drive["offset"], velocity, np.zeros_like(position))
    links = inertias(plant, start, position)
    return Machine(links + np.diag(plant.machine().armature), links, bias)


def _led(plant: Plant, time: Array, position: Array, velocity: Array, error: Array, need: Array, command: Array,
         volts: Array, grid: Array, h: float, integral: Array) -> Led:  # fmt: skip
    """The drives along a motion that is known at some times."""
    edges = edges_of(len(command), h)
    path = CubicHermiteSpline(time, position + plant.drive["offset"], velocity)
    speed = path.derivative()(np.clip(edges, time[0], time[-1]))
    at = np.clip(grid, time[0], time[-1])
    return lead(plant, path(at), speed, _on(time, error, grid), need, command, volts, h, integral)


def _expected(time: Array, machine: Machine, led: Led, grid: Array, h: float) -> Array:
    """Position, velocity and acceleration at the stamps, of the model alone and from rest. Shape (3, t, n)."""
    given = led.smooth + led.dry - _on(time, machine.bias, grid)
    acceleration = np.linalg.solve(_on(time, machine.inertia, grid), given[..., None])[..., 0]
    speed = np.cumsum(acceleration, axis=0) * h  # half a step after the times of the grid, as engines have it
    way = np.cumsum(np.vstack([np.zeros_like(speed[:1]), speed[:-1]]), axis=0) * h
    middle = speed - 0.5 * h * acceleration
    path = CubicHermiteSpline(grid, way, middle)
    edges = np.concatenate([time[:1], (time[:-1] + time[1:]) / 2, time[-1:]])
    mean = np.diff(make_interp_spline(grid, middle, k=1)(edges), axis=0) / np.diff(edges)[:, None]
    return np.stack([path(time), path.derivative()(time), mean])


def _unsure(known: list[Led], time: Array, grid: Array) -> Array:
    """The variance of what drives give, as the motion is not known exactly; friction that is open is uniform."""
    at, by_position, by_velocity = known
    spread = (by_position.smooth - at.smooth) ** 2 + (by_velocity.smooth - at.smooth) ** 2 + at.open**2 / 3
    return _on(grid, spread, time)


def _on(time: Array, values: Array, at: Array) -> Array:
    """Values along the first axis, linearly between their times and constant beyond."""
    found: Array = make_interp_spline(time, values, k=1)(np.clip(at, time[0], time[-1]))
    return found
