"""The gains of position servos, where the effort that was measured beside error and speed tells them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from realitygap_engines.model.robot import Joint

from realitygap.recording import Recording
from realitygap.recording.commands import held_at
from realitygap.scenario.file import ScenarioFile
from realitygap.scenario.servos import PidServo
from realitygap.trace.trace import Array

TOLD = 0.95
"""The share of an effort that gains have to explain: what is left is noise, and no integral, limit or current."""
CLEARLY = 0.5
"""As much of what a D on the error leaves one on the speed may leave at most, to be taken for that."""
BEYOND = 1.5
"""So many times the URDF's effort limit is what the joint may give for a moment, and no more."""
FEWEST = 200
"""Samples of a joint, at least."""
AT_LIMIT, OFTEN = 0.97, 0.02
"""Efforts above this share of the largest are at a limit, where these are more than that share of all."""


@dataclass(frozen=True)
class Gains:
    """Of a servo: effort = kp·e + kd·de/dt, or, with the D `on_speed`, kp·e - kd·q̇; and the share it explains."""

    kp: float
    kd: float
    on_speed: bool
    share: float


def measured_gains(
    file: ScenarioFile, joints: Sequence[Joint], recordings: Sequence[Recording], held: bool
) -> dict[str, Gains]:
    """The gains of each joint that measured efforts tell; none where commands are no positions, or servos are known.

    Args:
        file: the draft.
        joints: of the robot, as the recordings have them.
        recordings: all of the draft.
        held: whether commands are held, and not samples of a trajectory.
    """
    scenario = file.scenario
    positions = scenario.motion is not None and scenario.motion.meaning == "position"
    if not positions or not all(isinstance(s, PidServo) for s in scenario.servos):
        return {}
    found = {}
    for j, joint in enumerate(joints):
        seen = [rows for r in recordings if (rows := _rows(r, j, held)) is not None]
        rows = np.concatenate(seen) if seen else np.zeros((0, 4))
        gains = _fitted(rows, held) if len(rows) >= FEWEST and _gives(joint, rows[:, 3]) else None
        if gains is not None:
            found[joint.name] = gains
    return found


def _gives(joint: Joint, effort: Array) -> bool:
    """Whether a joint can give such efforts: a load in thousandths or a current in mA tells no gains in N·m."""
    return bool(np.abs(effort).max() <= BEYOND * joint.effort)


def _rows(recording: Recording, j: int, held: bool) -> Array | None:
    """Error, rate of the command, speed and effort of a joint, where all are known. Shape (t, 4)."""
    trace, command = recording.trace, recording.command[:, j]
    if trace.position is None or trace.effort is None or len(trace.time) < 2 or not np.isfinite(command).any():
        return None
    time, position = trace.time, trace.position[:, j]
    known = np.isfinite(command)
    if held:
        asked = held_at(recording.command_time, command, time)
    else:
        asked = np.interp(time, recording.command_time[known], command[known], left=np.nan, right=np.nan)
    speed = np.gradient(position, time) if trace.velocity is None else trace.velocity[:, j]
    rows = np.column_stack([asked - position, np.gradient(asked, time), speed, trace.effort[:, j]])
    known_rows: Array = rows[np.isfinite(rows).all(axis=1)]
    return known_rows


def _fitted(rows: Array, held: bool) -> Gains | None:
    """The gains that explain an effort; None where none do. Between the steps of a held command both kinds are one."""
    effort = np.abs(rows[:, 3])
    limited = effort > AT_LIMIT * effort.max(initial=0.0)
    rows = rows[~limited] if limited.mean() > OFTEN else rows
    if len(rows) < FEWEST or not rows[:, 3].any():
        return None
    error, rate, speed, effort = rows.T
    on_speed = _least_squares(error, -speed, effort)
    on_error = on_speed if held else _least_squares(error, rate - speed, effort)
    own = not held and on_speed[2] < CLEARLY * on_error[2]
    kp, kd, left = on_speed if own else on_error
    share = 1.0 - left / float(effort @ effort)
    return Gains(kp, max(kd, 0.0), own and kd > 0.0, share) if share > TOLD and kp > 0.0 else None


def _least_squares(error: Array, rate: Array, effort: Array) -> tuple[float, float, float]:
    """kp and kd, and the sum of squares that they leave."""
    both = np.column_stack([error, rate])
    (kp, kd), *_ = np.linalg.lstsq(both, effort, rcond=None)
    return float(kp), float(kd), float(np.sum((effort - both @ [kp, kd]) ** 2))
