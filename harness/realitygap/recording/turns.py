"""Encoders that begin again after a whole turn: their jumps are taken out, so that an angle is that of the joint.

A joint that turns through ±π is read as -π next; what reads it knows how far it moves from one reading to the next, and
a jump of a whole turn among steps of a hundredth of it is none that any motor makes.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter

from realitygap.recording.absent import BRIDGED
from realitygap.recording.lack import Lack
from realitygap.recording.outliers import USUAL
from realitygap.trace.trace import Array, Trace

TURN = 2.0 * np.pi
FASTER = 2.0
"""How many times its usual or its momentary speed a joint may have from one reading to the next."""
AROUND = (1, 1, 0, 1, 1)
"""The steps that tell the momentary speed at one of them."""
CLEAR = 2.0
"""How many times further than it can move a joint must have jumped."""
ABOUT = 0.05 * TURN
"""A jump across a pause that is this near to a turn may be one, and may be a motion."""
ROUNDED = 1e-6
"""rad: angles in a file are rounded."""
LISTED = 3
"""Jumps that a sentence places; the others it counts."""


def without_turns(time: Array, value: Array) -> tuple[Array, list[Array], list[Array]]:
    """Angles that go on where their encoders began again.

    A step is a turn of the encoder where it is more than a joint can move in its time, at twice the speed that it
    usually has or has around it, and where what is left of it without a whole turn is no more than that. Across a
    pause, of more than `BRIDGED` usual periods, a joint may have moved as well, and is left as it was read.

    Args:
        time: Shape (t,) [s].
        value: Shape (t, n) [rad], NaN where it is unknown.

    Returns:
        The angles (t, n), and of every joint the times [s] of the turns and those of pauses with a jump as large.
    """
    out, turned, unknown = value, [], []
    for j, column in enumerate(value.T):  # a column at a time: recordings are long
        known = np.flatnonzero(np.isfinite(column))
        count, doubtful = _turns(time[known], column[known])
        turned.append(time[known][1:][count != 0])
        unknown.append(time[known][1:][doubtful])
        if len(turned[-1]):
            out = out.copy() if out is value else out
            out[known[1:], j] -= TURN * np.cumsum(count)
    return out, turned, unknown


def _turns(time: Array, angle: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Whole turns from one reading to the next (t - 1,), and which of these steps may be one across a pause."""
    steps, spans = np.diff(angle), np.diff(time)
    turns = np.rint(steps / TURN)
    if not (np.abs(turns) == 1).any():
        return np.zeros(len(steps)), np.zeros(len(steps), dtype=bool)
    left = np.abs(steps - TURN * turns)
    speed = left / spans
    around = maximum_filter(speed, footprint=AROUND, mode="constant")
    usual = np.maximum(np.quantile(speed, USUAL), around)
    possible = FASTER * usual * spans + ROUNDED
    one = np.abs(turns) == 1
    going = spans <= BRIDGED * np.median(spans)
    counted = one & going & (left <= possible) & (np.abs(steps) > CLEAR * possible)
    return np.where(counted, turns, 0.0), np.asarray(one & ~going & (left < ABOUT))


def command_without_turns(
    time: Array, command: Array, trace: Trace, turned: Sequence[Array]
) -> tuple[Array, list[Array]]:
    """Commanded angles that go on as the measured ones do.

    A command may jump as far as it likes, so that its turns are taken out only where it is nearer to the measured
    position then. Where either had turns, the command is that of as many whole turns as bring it nearest.

    Args:
        time: Shape (m,) [s].
        command: Shape (m, n) [rad], NaN where there is none.
        trace: what was measured, without the turns of its encoders.
        turned: for n joints the times of these.

    Returns:
        The commands (m, n), and of every joint the times [s] of the turns that were taken out.
    """
    smooth, at, _ = without_turns(time, command)
    out, taken = command, [np.empty(0)] * len(trace.joints)
    assert trace.position is not None
    for j in range(len(trace.joints)):
        if not len(at[j]) and not len(turned[j]):
            continue
        position = np.interp(time, trace.time, trace.position[:, j])
        read, went_on = (_nearest(c[:, j], position) for c in (command, smooth))
        nearer = _distance(went_on, position) < _distance(read, position)
        out = out.copy() if out is command else out
        out[:, j] = went_on if nearer else read
        taken[j] = at[j] if nearer else taken[j]
    return out, taken


def _nearest(angle: Array, other: Array) -> Array:
    """An angle (t,) with as many whole turns off as bring it nearest to another one, in the median."""
    away = (angle - other)[np.isfinite(angle - other)]
    return np.asarray(angle - TURN * np.rint(np.median(away) / TURN)) if len(away) else angle


def _distance(angle: Array, other: Array) -> float:
    away = np.abs(angle - other)
    return float(away[np.isfinite(away)].mean()) if np.isfinite(away).any() else np.inf


def told_turns(joints: Sequence[str], signal: str, at: Sequence[Array]) -> list[Lack]:
    """A sentence for every joint whose angle began again, at some times [s]."""
    return [
        Lack(
            "turns",
            f"the {signal} of {joint} jumps by a whole turn {len(times)} time{'s' * (len(times) > 1)} "
            f"({_listed(times)}), as no motion does: its angle begins again there, and the turns are counted",
            1.0,
        )
        for joint, times in zip(joints, at, strict=True)
        if len(times)
    ]


def told_pauses(joints: Sequence[str], at: Sequence[Array]) -> list[Lack]:
    """A sentence for every joint of which it is not known whether it turned or its angle began again."""
    return [
        Lack(
            "turns",
            f"the position of {joint} is a whole turn further after a pause ({_listed(times)}): a motion, or an angle "
            "that begins again; taken as it was read",
            1.0,
        )
        for joint, times in zip(joints, at, strict=True)
        if len(times)
    ]


def _listed(times: Array) -> str:
    return f"at {', '.join(f'{t:.3f}' for t in times[:LISTED])}{', ...' * (len(times) > LISTED)} s"
