"""Commands on the simulation's clock: recorded commands held until the next one, delayed by any time."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from realitygap.robot.drive import Array


@dataclass(frozen=True)
class Commands:
    """What the servos are told.

    Attributes:
        time: when each command was sent, from the start of the simulation [s]. Shape (m,).
        value: Shape (m, n); NaN where the servo is off.
        held: True: a command holds until the next one (a bus); False: linear in between (a trajectory).
    """

    time: Array
    value: Array
    held: bool = True


def on_steps(commands: Commands, steps: int, h: float, delay: Array, first: int = 0) -> Array:
    """The mean command over every step of length h from a first one on, after each joint's delay [s]. Shape (steps, n).

    The mean over the step, rather than the value at its start, makes the result a continuous function of the delay and
    of the stamps, whatever the step. A step's effort changes the velocity from half a step before its time to half a
    step after it, so the mean is taken there. Before the first command the first one holds. A servo
    is off in the steps whose middle has no command.
    """
    edges = edges_of(steps, h, first)
    # of a long motion, what comes later has no bearing, and what came before has none where one begins in the middle
    begin = edges[0] - float(delay.max(initial=0.0)) if first else -np.inf
    commands = _about(commands, begin, edges[-1] - float(delay.min(initial=0.0)))
    out = np.empty((steps, commands.value.shape[1]))
    for late in np.unique(delay):
        columns = np.flatnonzero(delay == late)
        out[:, columns] = _means(commands, columns, edges - late, h)
    return out


def edges_of(steps: int, h: float, first: int = 0) -> Array:
    """Where steps begin and end [s], in the sense of `on_steps`. Shape (steps + 1,)."""
    return np.asarray((np.arange(first, first + steps + 1) - 0.5) * h)


def _about(commands: Commands, begin: float, end: float) -> Commands:
    """The commands that matter between two times."""
    first, last = np.searchsorted(commands.time, [begin, end], side="right")
    near = slice(max(int(first) - 1, 0), int(last) + 1)
    return Commands(commands.time[near], commands.value[near], commands.held)


def _means(commands: Commands, columns: NDArray[np.intp], edges: Array, h: float) -> Array:
    time, value = commands.time, commands.value[:, columns]
    off = np.isnan(value)
    filled = np.where(off, 0.0, value)
    at = np.clip(np.searchsorted(time, edges, side="right") - 1, 0, len(time) - 1)
    mean: Array = np.diff(_integral(commands, filled, edges, at), axis=0) / h
    if off.any():
        middle = np.clip(np.searchsorted(time, edges[:-1] + h / 2, side="right") - 1, 0, len(time) - 1)
        on = np.diff(_integral(commands, np.where(off, 0.0, 1.0), edges, at), axis=0) / h
        mean = np.where(off[middle], np.nan, mean / np.where(off[middle], 1.0, on))  # of the part in which it is on
    return np.where(np.isnan(mean), mean, _within(mean, filled, at))


def _integral(commands: Commands, value: Array, edges: Array, at: NDArray[np.intp]) -> Array:
    """The integral of a command from its first stamp to every edge; `at` is the last stamp before each edge.

    It is piecewise linear between stamps for a held command, and quadratic for a linear one.
    """
    time = commands.time
    width = np.diff(time)[:, None]
    pieces = value[:-1] * width if commands.held else 0.5 * (value[:-1] + value[1:]) * width
    integral = np.vstack([np.zeros(value.shape[1]), np.cumsum(pieces, axis=0)])
    into = (edges - time[at])[:, None]
    area: Array = integral[at] + value[at] * into
    if not commands.held:
        following = np.minimum(at + 1, len(time) - 1)
        gap = np.where(following > at, time[following] - time[at], 1.0)[:, None]
        slope = np.where((into > 0) & (following > at)[:, None], (value[following] - value[at]) / gap, 0.0)
        area += 0.5 * slope * into * into
    return area


def _within(mean: Array, filled: Array, at: NDArray[np.intp]) -> Array:
    """The mean, put back between the commands it was made of: a step never overshoots by rounding."""
    ends = np.minimum(at[1:] + 1, len(filled) - 1)
    low = np.minimum(np.minimum(filled[at[:-1]], filled[at[1:]]), filled[ends])
    high = np.maximum(np.maximum(filled[at[:-1]], filled[at[1:]]), filled[ends])
    return np.asarray(np.clip(mean, low, high))
