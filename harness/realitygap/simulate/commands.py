"""Commands on the simulation's clock: recorded commands held until the next one, delayed by any time."""

from dataclasses import dataclass

import numpy as np
from realitygap_engines.law.compiled import compiled

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


def going_on(commands: Commands, duration: float) -> Commands:
    """A trajectory that goes on as it came where it ends with a motion of this duration [s]: what recorded it stopped,
    and no joint. Its rate, which a controller takes over a step and the next one, would else break off in the last.
    """
    if commands.held or len(commands.time) < 2:
        return commands
    time, value = commands.time, commands.value
    after = time[-1] + (time[-1] - time[-2])
    if duration >= after:  # one more would have been recorded
        return commands
    further = 2.0 * value[-1] - value[-2]
    further = np.where(np.isnan(further), value[-1], further)  # switched on or off there
    return Commands(np.append(time, after), np.vstack([value, further]), commands.held)


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
        value = np.ascontiguousarray(commands.value[:, columns])  # compiled once, for one joint and for many
        out[:, columns] = _means(commands.time, value, commands.held, edges - late, h)
    return out


def edges_of(steps: int, h: float, first: int = 0) -> Array:
    """Where steps begin and end [s], in the sense of `on_steps`. Shape (steps + 1,)."""
    return np.asarray((np.arange(first, first + steps + 1) - 0.5) * h)


def _about(commands: Commands, begin: float, end: float) -> Commands:
    """The commands that matter between two times."""
    first, last = np.searchsorted(commands.time, [begin, end], side="right")
    near = slice(max(int(first) - 1, 0), int(last) + 1)
    return Commands(commands.time[near], commands.value[near], commands.held)


@compiled
def _means(time, value, held, edges, h):  # type: ignore[no-untyped-def]
    """The mean of commands over every step between edges [s], of which the first is the earliest. Shape (steps, n).

    Times [s] are Shape (m,) and commands (m, n). A command's integral from the first stamp on is piecewise linear
    between stamps for a held one, and quadratic for a linear one; so is that of where it is on, which a mean is of.
    """
    steps, last, n = len(edges) - 1, len(time) - 1, value.shape[1]
    out = np.empty((steps, n))
    at = np.clip(np.searchsorted(time, edges, side="right") - 1, 0, last)
    middle = np.clip(np.searchsorted(time, edges[:-1] + h / 2, side="right") - 1, 0, last)
    for j in range(n):
        told, on = np.empty(last + 1), np.ones(last + 1)
        for i in range(last + 1):
            off = np.isnan(value[i, j])
            told[i], on[i] = (0.0, 0.0) if off else (value[i, j], 1.0)
        goes_off = on.min() == 0.0
        area = _integral(time, told, held, edges, at)
        lasting = _integral(time, on, held, edges, at) if goes_off else edges
        for k in range(steps):
            mean = (area[k + 1] - area[k]) / h
            if goes_off:
                if on[middle[k]] == 0.0:
                    out[k, j] = np.nan
                    continue
                mean /= (lasting[k + 1] - lasting[k]) / h  # of the part in which it is on
            # back between the commands it was made of: a step never overshoots by rounding
            ends = told[at[k]], told[at[k + 1]], told[min(at[k + 1] + 1, last)]
            out[k, j] = min(max(mean, min(ends)), max(ends))
    return out


@compiled
def _integral(time, value, held, edges, at):  # type: ignore[no-untyped-def]
    """The integral of one command (m,) from its first stamp to every edge; `at` is the last stamp before each edge."""
    last = len(time) - 1
    whole, out = np.zeros(last + 1), np.empty(len(edges))
    for i in range(last):
        width = time[i + 1] - time[i]
        whole[i + 1] = whole[i] + (value[i] * width if held else 0.5 * (value[i] + value[i + 1]) * width)
    for k in range(len(edges)):
        i = at[k]
        into = edges[k] - time[i]
        out[k] = whole[i] + value[i] * into
        if not held and into > 0.0 and i < last:
            out[k] += 0.5 * ((value[i + 1] - value[i]) / (time[i + 1] - time[i])) * into * into
    return out
