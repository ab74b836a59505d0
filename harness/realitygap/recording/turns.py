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
from realitygap.trace.trace import Array

TURN = 2.0 * np.pi
FASTER = 2.0
"""How many times its usual or its momentary speed a joint may have from one reading to the next."""
AROUND = (1, 1, 0, 1, 1)
"""The steps that tell the momentary speed at one of them."""
CLEAR = 2.0
"""How many times further than it can move a joint must have jumped."""
ABOUT = 0.05 * TURN
"""A jump across a pause that is this near to a turn may be one, and may be a motion."""
NO_LIMITS = (-np.inf, np.inf)
LEEWAY = 0.35
"""rad: a zero may be this far off, and a stop is not where the URDF has it."""
MOST, ALL = 0.5, 0.99
"""The parts of a joint's readings that tell where it is; the rest are outliers, and motions past a limit."""
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


def within_limits(value: Array, limits: Array) -> tuple[Array, Array]:
    """Angles of which most are beyond their joints' limits, and all but outliers within them a turn up or down.

    An encoder from 0 to 2π reads a joint that stands below its zero a turn too high.

    Args:
        value: Shape (t, n) [rad], NaN where it is unknown.
        limits: the lower and the upper one. Shape (n, 2) [rad].

    Returns:
        The angles there (t, n), and the turns that each joint's went up (n,).
    """
    moved = np.zeros(value.shape[1])
    for j, column in enumerate(value.T):
        known = column[np.isfinite(column)]
        if len(known) and _inside(known, limits[j]) < MOST:
            fitting = [turn for turn in (-1.0, 1.0) if _inside(known + turn * TURN, limits[j]) > ALL]
            moved[j] = fitting[0] if fitting else 0.0
    return (value + TURN * moved if moved.any() else value), moved


def _inside(angle: Array, limits: Array) -> float:
    """The part of known angles (t,) that is within limits (2,), or as good as that."""
    return float(((angle >= limits[0] - LEEWAY) & (angle <= limits[1] + LEEWAY)).mean())


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


def told_limits(joints: Sequence[str], moved: Array, limits: Array) -> list[Lack]:
    """A sentence for every joint of which the angles went up or down by a turn (n,), to limits (n, 2)."""
    return [
        Lack(
            "turns",
            f"the position of {joint} was read a whole turn {'above' if turn < 0 else 'below'} its limits "
            f"{low:.4g} and {high:.4g}: taken a turn {'lower' if turn < 0 else 'higher'}",
            1.0,
        )
        for joint, turn, (low, high) in zip(joints, moved, limits, strict=True)
        if turn
    ]


def _listed(times: Array) -> str:
    return f"at {', '.join(f'{t:.3f}' for t in times[:LISTED])}{', ...' * (len(times) > LISTED)} s"
