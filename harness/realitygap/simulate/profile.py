"""Firmware that follows position commands with a bounded speed and acceleration: a trapezoidal profile to each goal.

Every command is a goal when it arrives, and the way to it is planned anew from where the profile is and how fast it
goes: as fast as both bounds allow, to come to rest at the goal. That is worked out in continuous time, so that the
result does not depend on the step and is a continuous function of the bounds and of the delay.
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from realitygap_engines.law.compiled import compiled

from realitygap.robot.drive import Array
from realitygap.simulate.commands import Commands, edges_of, on_steps

PERIOD = 1e-3
"""A trajectory that is linear between its samples is a new goal each period of a servo's own loop [s]."""


class Told:
    """What servos are told over the steps of a motion, after their profiles and delays.

    Args:
        commands: what is sent.
        drive: with `profile_speed` [rad/s] and `profile_acceleration` [rad/s²]; infinite: no bound. Shape (n,).
        steps: how many there are in all.
        h: the length of a step [s].
        delay: of each joint [s]. Shape (n,).
    """

    def __init__(self, commands: Commands, drive: NDArray[np.void], steps: int, h: float, delay: Array) -> None:
        self._commands, self._h, self._delay = commands, h, delay
        self._profiled = dict(_profiled(commands, drive, edges_of(steps, h), h, delay))

    def over(self, first: int, steps: int) -> Array:
        """The mean command of each servo over each of some steps from a first one on. Shape (steps, n)."""
        out = on_steps(self._commands, steps, self._h, self._delay, first)
        for j, mean in self._profiled.items():
            out[:, j] = np.where(np.isnan(out[:, j]), np.nan, mean[first : first + steps])
        return out


def told(commands: Commands, drive: NDArray[np.void], steps: int, h: float, delay: Array) -> Array:
    """What servos are told over all steps. Shape (steps, n)."""
    return Told(commands, drive, steps, h, delay).over(0, steps)


def _profiled(
    commands: Commands, drive: NDArray[np.void], edges: Array, h: float, delay: Array
) -> Iterator[tuple[int, Array]]:
    """Joints with a bound, and the mean of their profile over every step between edges (steps + 1,)."""
    for j in np.flatnonzero(np.isfinite(drive["profile_speed"]) | np.isfinite(drive["profile_acceleration"])):
        time, goal = _goals(commands, int(j))
        if not len(time):
            continue
        profile = phases(time, goal, float(drive["profile_speed"][j]), float(drive["profile_acceleration"][j]))
        yield int(j), np.diff(_integral(profile, edges - delay[j])) / h


def _goals(commands: Commands, j: int) -> tuple[Array, Array]:
    """When each goal of a joint arrives, and the goal. While a servo is off, its profile waits at the next command."""
    time, goal = commands.time, commands.value[:, j]
    if not commands.held and len(time) > 1:
        grid = np.arange(time[0], time[-1], PERIOD)
        time, goal = np.append(grid, time[-1]), np.append(np.interp(grid + PERIOD / 2, time, goal), goal[-1])
    known = np.flatnonzero(np.isfinite(goal))
    if not len(known):
        return time[:0], goal[:0]
    following = known[np.minimum(np.searchsorted(known, np.arange(len(goal))), len(known) - 1)]
    return time, goal[following]


@compiled
def _integral(profile, at):  # type: ignore[no-untyped-def]
    """The integral of a profile from its beginning to increasing times; before it, the first position holds. Shape of
    `at`.
    """
    start, p, v, a = profile
    last, out = len(start) - 1, np.empty(len(at))
    k, before = 0, 0.0
    for i in range(len(at)):
        while k < last and start[k + 1] <= at[i]:
            lasting = start[k + 1] - start[k]
            before += lasting * (p[k] + lasting * (v[k] / 2 + lasting * a[k] / 6))
            k += 1
        lasting = at[i] - start[k]
        rate = p[0] if lasting < 0.0 else p[k] + lasting * (v[k] / 2 + lasting * a[k] / 6)
        out[i] = before + lasting * rate
    return out


@compiled
def phases(time, goal, speed, acceleration):  # type: ignore[no-untyped-def]
    """The profile to goals that arrive at increasing times, as phases of constant acceleration.

    Returns:
        Start [s], position [rad], speed [rad/s] and acceleration [rad/s²] of each phase; the last one rests. Shape
        (4, phases).
    """
    out = np.zeros((4, 4 * len(time) + 1))
    count, p, v = 0, goal[0], 0.0
    lasts, pulls = np.zeros(3), np.zeros(3)
    for i in range(len(time)):
        now = time[i]
        end = time[i + 1] if i + 1 < len(time) else np.inf
        way = goal[i] - p
        if acceleration == np.inf:
            sign, top = np.sign(way), speed
            lasts[:], pulls[:] = 0.0, 0.0
            lasts[1] = abs(way) / speed
        else:
            beyond = way - v * abs(v) / (2.0 * acceleration)  # what is left where braking now would end
            sign = np.sign(beyond) if beyond != 0.0 else -np.sign(v)
            top = min(np.sqrt(max(acceleration * sign * way + 0.5 * v * v, 0.0)), speed)
            lasts[0], lasts[2] = (top - sign * v) / acceleration, top / acceleration
            cruise = sign * way - (2.0 * top * top - v * v) / (2.0 * acceleration)
            lasts[1] = max(cruise, 0.0) / top if top > 0.0 else 0.0
            pulls[0], pulls[2] = sign * acceleration, -sign * acceleration
        arrived = True
        for k in range(3):
            if lasts[k] <= 0.0:
                continue
            if k == 1:
                v = sign * top
            out[0, count], out[1, count], out[2, count], out[3, count] = now, p, v, pulls[k]
            count += 1
            lasting = min(lasts[k], end - now)
            p += lasting * (v + 0.5 * lasting * pulls[k])
            v += lasting * pulls[k]
            if lasting < lasts[k]:
                arrived = False
                break
            now += lasting
        if arrived:
            p, v = goal[i], 0.0
            out[0, count], out[1, count] = now, p
            out[2, count], out[3, count] = 0.0, 0.0
            count += 1
    return out[:, :count]
