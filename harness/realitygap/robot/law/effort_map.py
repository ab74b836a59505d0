"""Efforts by table: see `robot.effort_map`."""

import numpy as np
from realitygap_engines.law.compiled import compiled

from realitygap.robot.law.transmission import weight

ANGLE, SPEED, ERROR, LOAD, REVERSAL, SUPPLY = 0, 1, 2, 3, 4, 5
"""Codes of the variables, in the order of `effort_map.VARIABLES`."""
TURNING = 0.01
"""A speed below this [rad/s or m/s] is no direction: a joint that rests does not reverse."""
SLOW = 1e-3
"""What a map loses within this speed from rest [rad/s or m/s] is the damping of a joint that rests."""


@compiled
def add_mapped(  # type: ignore[no-untyped-def]
    maps, numbers, drive, state, command, w, inertia, recorded, t, h, effort, damping, log
):
    """Add the efforts of all maps to `effort` and `damping` of the joint law; arguments as in `drive_effort`, after it.

    What an effort loses from rest to the speed is damping, and acts on the speed amid the step as other damping does:
    a map that is as steep as dry friction does not ring.
    """
    given = np.zeros(maps.size)
    for m in range(maps.size):
        p = maps[m]
        j = p.joint
        d, s = drive[j], state[j]
        speed = w[j] if d.stiffness == 0.0 else log[j].rotor
        if abs(speed) > TURNING and speed * s.heading <= 0.0:
            s.reversed = t if s.heading != 0.0 else 0.0
            s.heading = np.sign(speed)
        a = measured(p.first, d, s, log[j], command[j], speed, recorded, t)
        b = measured(p.second, d, s, log[j], command[j], speed, recorded, t)
        given[m] = between(p, numbers, a, b)
        effort[j] += given[m]
        if d.stiffness == 0.0 and (p.first == SPEED or p.second == SPEED):
            moving = speed if abs(speed) > SLOW else SLOW
            there = between(p, numbers, moving if p.first == SPEED else a, moving if p.second == SPEED else b)
            rest = between(p, numbers, 0.0 if p.first == SPEED else a, 0.0 if p.second == SPEED else b)
            lost = max((rest - there) / moving, 0.0)
            late = weight(h * lost / inertia[j])
            effort[j] += late * lost * w[j]
            damping[j] += late * lost
    for m in range(maps.size):
        state[maps[m].joint].mapped = 0.0
    for m in range(maps.size):
        state[maps[m].joint].mapped += given[m]


@compiled
def map_along(maps, numbers, time, reading, velocity, load, volts, out):  # type: ignore[no-untyped-def]
    """Take the efforts of all maps from `out` (t, n), along a motion that no servo drives: without position errors."""
    for m in range(maps.size):
        p = maps[m]
        j = p.joint
        heading, reversed_at = 0.0, 0.0
        for k in range(len(time)):
            v = velocity[k, j]
            if abs(v) > TURNING and v * heading <= 0.0:
                reversed_at = time[k] if heading != 0.0 else 0.0
                heading = np.sign(v)
            values = (reading[k, j], v, 0.0, load[k, j], time[k] - reversed_at, volts[k], 0.0)
            out[k, j] -= between(p, numbers, values[p.first], values[p.second])


@compiled
def between(p, numbers, a, b):  # type: ignore[no-untyped-def]
    """The value of a map at a of its first variable and b of its second."""
    rows, columns = numbers[p.at : p.at + p.rows], numbers[p.at + p.rows : p.at + p.rows + p.columns]
    values = p.at + p.rows + p.columns
    i, x = cell(rows, a)
    k, y = cell(columns, b)
    out = 0.0
    for row, share in ((i, 1.0 - x), (i + 1, x)):
        for column, part in ((k, 1.0 - y), (k + 1, y)):
            if share * part > 0.0:
                out += share * part * numbers[values + row * p.columns + column]
    return out


@compiled
def measured(variable, d, s, logged, command, speed, recorded, t):  # type: ignore[no-untyped-def]
    """The value of a variable by its code; of none, 0."""
    if variable < 0:
        return 0.0
    reading = logged.encoder - d.offset
    if variable == ANGLE:
        return reading
    if variable == SPEED:
        return speed
    if variable == ERROR:
        return 0.0 if np.isnan(command) else command - reading
    if variable == LOAD:
        return logged.transmitted + s.mapped
    if variable == REVERSAL:
        return t - s.reversed
    return recorded if recorded > 0.0 else s.bus


@compiled
def cell(knots, x):  # type: ignore[no-untyped-def]
    """The knot before x, and the part of the way to the next one; the first or last knot beyond them."""
    last = knots.size - 1
    if x <= knots[0]:
        return 0, 0.0
    if x >= knots[last]:
        return last, 0.0
    i = np.searchsorted(knots, x, side="right") - 1
    return i, (x - knots[i]) / (knots[i + 1] - knots[i])
