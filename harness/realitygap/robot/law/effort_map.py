"""Efforts by table: see `robot.effort_map`."""

import numpy as np
from realitygap_engines.law.compiled import compiled

from realitygap.robot.law.transmission import weight

ANGLE, SPEED, ERROR, LOAD, REVERSAL, SUPPLY = 0, 1, 2, 3, 4, 5
"""Codes of the variables, in the order of `effort_map.VARIABLES`."""
TURNING = 0.01
"""A speed below this [rad/s or m/s] is no direction: a joint that rests does not reverse."""


@compiled
def add_mapped(  # type: ignore[no-untyped-def]
    maps, numbers, drive, state, command, w, inertia, recorded, t, h, effort, damping, log
):
    """Add the efforts of all maps to `effort` and `damping` of the joint law; arguments as in `drive_effort`, after it.

    Where an effort falls with the speed it is damping, and acts on the speed amid the step as other damping does.
    """
    for m in range(maps.size):
        p = maps[m]
        j = p.joint
        d, s = drive[j], state[j]
        speed = w[j] if d.stiffness == 0.0 else log[j].rotor
        if abs(speed) > TURNING and speed * s.heading <= 0.0:
            s.reversed = t if s.heading != 0.0 else 0.0
            s.heading = np.sign(speed)
        a = measured(p.first, d, s, log[j], command[j], speed, recorded, t)
        b = measured(p.second, d, s, log[j], command[j], speed, recorded, t) if p.second >= 0 else 0.0
        rows, columns = numbers[p.at : p.at + p.rows], numbers[p.at + p.rows : p.at + p.rows + p.columns]
        values = numbers[p.at + p.rows + p.columns : p.at + p.rows + p.columns + p.rows * p.columns]
        i, x, wide = cell(rows, a)
        k, y, high = cell(columns, b)
        i1, k1 = min(i + 1, p.rows - 1), min(k + 1, p.columns - 1)
        low_low, low_high = values[i * p.columns + k], values[i * p.columns + k1]
        high_low, high_high = values[i1 * p.columns + k], values[i1 * p.columns + k1]
        torque = (1 - x) * ((1 - y) * low_low + y * low_high) + x * ((1 - y) * high_low + y * high_high)
        slope = 0.0
        if d.stiffness == 0.0:
            if p.first == SPEED and wide > 0.0:
                slope += ((1 - y) * (high_low - low_low) + y * (high_high - low_high)) / wide
            if p.second == SPEED and high > 0.0:
                slope += ((1 - x) * (low_high - low_low) + x * (high_high - high_low)) / high
        late = weight(-h * slope / inertia[j]) if slope < 0.0 else 0.0
        effort[j] += torque - slope * late * w[j]
        damping[j] -= slope * late


@compiled
def measured(variable, d, s, logged, command, speed, recorded, t):  # type: ignore[no-untyped-def]
    """The value of a variable by its code."""
    reading = logged.encoder - d.offset
    if variable == ANGLE:
        return reading
    if variable == SPEED:
        return speed
    if variable == ERROR:
        return 0.0 if np.isnan(command) else command - reading
    if variable == LOAD:
        return logged.transmitted
    if variable == REVERSAL:
        return t - s.reversed
    return recorded if recorded > 0.0 else s.bus


@compiled
def cell(knots, x):  # type: ignore[no-untyped-def]
    """The knot before x, the part of the way to the next one, and how far that is; 0 where x lies beyond the knots."""
    last = knots.size - 1
    if x <= knots[0] or last == 0:
        return 0, 0.0, 0.0
    if x >= knots[last]:
        return last, 0.0, 0.0
    i = np.searchsorted(knots, x, side="right") - 1
    wide = knots[i + 1] - knots[i]
    return i, (x - knots[i]) / wide, wide
