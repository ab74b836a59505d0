"""What the scenario's servos give for an error, what they give at most, and how slow they are."""

import numpy as np

from realitygap.check.observed import Observed
from realitygap.robot.drive import DC, PID
from realitygap.trace.trace import Array

UNKNOWN_SUPPLY = 12.0
"""V: where the supply is recorded elsewhere; only factors of ten are judged by it."""


def supply(o: Observed) -> Array:
    """The usual supply of every servo [V]. Shape (n,)."""
    recorded = float(np.median(o.recording.supply)) if len(o.recording.supply) else UNKNOWN_SUPPLY
    d = o.plant.drive
    return np.asarray(np.where(d["recorded_supply"] == 1, recorded, d["supply"]))


def stiffness(o: Observed) -> Array:
    """What every servo gives per position error [N·m/rad or N/m]. Shape (n,)."""
    d = o.plant.drive
    dc = d["gain"] * supply(o) * d["torque_constant"] / d["resistance"]
    return np.asarray(np.where(d["kind"] == DC, dc, np.where(d["kind"] == PID, d["kp"], d["gain"] * d["kv"] * d["kp"])))


def limit(o: Observed) -> Array:
    """What every servo gives at most [N·m or N]; inf where nothing says it. Shape (n,)."""
    d = o.plant.drive
    stall = d["torque_constant"] / d["resistance"] * d["duty_limit"] * supply(o)
    return np.asarray(np.where(d["kind"] == DC, stall, d["effort_limit"]))


def slowness(o: Observed) -> Array:
    """The first-order lag of every servo [s]: its damping over its stiffness. Shape (n,); NaN where it has none."""
    d = o.plant.drive
    with np.errstate(divide="ignore", invalid="ignore"):
        dc = (d["torque_constant"] ** 2 / d["resistance"] + d["viscous"]) / stiffness(o)
        pid = (d["kd"] + d["viscous"]) / d["kp"]
        lag = np.where(d["kind"] == DC, dc, np.where(d["kind"] == PID, pid, 1.0 / d["kp"]))
    return np.asarray(np.where(np.isfinite(lag), lag, np.nan))


def working_error(o: Observed, delay: float = 0.0) -> Array:
    """The error that every servo works on, for a command that comes late by `delay` [s]: no larger than what brings it
    to its limit. NaN where no command is in force. Shape (k, n).
    """
    d = o.plant.drive
    index = np.maximum(np.arange(len(o.clock)) - round(delay / o.step), 0)
    error = o.command[index] - o.position
    with np.errstate(divide="ignore", invalid="ignore"):
        most = np.where(d["kind"] == DC, d["duty_limit"] / d["gain"], limit(o) / stiffness(o))
    return np.asarray(np.clip(error, -np.nan_to_num(most, nan=np.inf), np.nan_to_num(most, nan=np.inf)))
