"""Commanded angles that are given within one turn: each is meant of the turn that its joint is in."""

import numpy as np
from numpy.typing import NDArray

from realitygap.recording.commands import held_at
from realitygap.recording.turns import ABOUT, LEEWAY, TURN
from realitygap.trace.trace import Array, Trace


def command_without_turns(
    time: Array, command: Array, trace: Trace, wraps: NDArray[np.bool_], limits: Array
) -> tuple[Array, list[Array]]:
    """Commanded angles of the turns that the measured ones are of.

    A command may jump as far as it likes, and past the end of its turn as well. From one jump to the next it is of as
    many whole turns as bring it nearest to where the joint is by then, and within its limits where there is such a
    turn. Where no angle of the joint was read to begin again, this is done only if the joint then is where it is told
    to be. A command that reaches further than a turn counts its turns itself: all of it is of as many whole ones.

    Args:
        time: Shape (m,) [s].
        command: Shape (m, n) [rad], NaN where there is none.
        trace: what was measured, without the turns of its encoders.
        wraps: the joints of which these began again. Shape (n,).
        limits: the lower and the upper one. Shape (n, 2) [rad].

    Returns:
        The commands (m, n), and of every joint the times [s] at which they went to another turn than it was read.
    """
    out, taken = command, [np.empty(0)] * len(trace.joints)
    assert trace.position is not None
    for j in range(len(trace.joints)):
        known = np.flatnonzero(np.isfinite(command[:, j]))
        if not len(known):
            continue
        asked = command[known, j]
        jumps = 1 + np.flatnonzero(np.abs(np.diff(asked)) > ABOUT)
        if np.ptp(asked) > TURN + ABOUT:
            jumps = jumps[:0]
        held = held_at(time, command[:, j], trace.time)
        there = np.isfinite(held) & np.isfinite(trace.position[:, j])
        if not there.any():
            continue
        clock, position = trace.time[there], trace.position[there, j]
        errors = position - held[there]
        if np.abs(errors).max() < 0.5 * TURN and _within(asked, limits[j]):
            continue
        away = np.split(errors, np.searchsorted(clock, time[known[jumps]]))
        sent = np.split(np.interp(time[known], clock, position) - asked, jumps)
        away = [a if len(a) else b for a, b in zip(away, sent, strict=True)]  # nothing was measured in short ones
        turns, left = _turns(np.split(asked, jumps), away, limits[j])
        if turns.any() and (wraps[j] or left <= ABOUT):
            out = out.copy() if out is command else out
            out[known, j] = asked + TURN * np.repeat(turns, np.diff([0, *jumps, len(asked)]))
            taken[j] = time[known[jumps[np.diff(turns) != 0]]]
    return out, taken


def _turns(stretches: list[Array], away: list[Array], limits: Array) -> tuple[Array, float]:
    """The turns that each of k stretches of commands lacks (k,), and how far [rad] the joint usually is from those that
    lack any; `away` is how far it was from each as it was given.

    It is seen in the later half of a stretch, as a joint takes its time to get there.
    """
    turns, left = np.zeros(len(away)), [np.empty(0)]
    for k, (stretch, error) in enumerate(zip(stretches, away, strict=True)):
        late = error[len(error) // 2 :]
        nearest = float(np.rint(np.median(late) / TURN))
        tried = (nearest, nearest - 1.0, nearest + 1.0)
        turns[k] = next((turn for turn in tried if _within(stretch + TURN * turn, limits)), nearest)
        if turns[k]:
            left.append(np.abs(late - TURN * turns[k]))
    found = np.concatenate(left)
    return turns, float(np.median(found)) if len(found) else np.inf


def _within(angle: Array, limits: Array) -> bool:
    return bool(angle.min() >= limits[0] - LEEWAY and angle.max() <= limits[1] + LEEWAY)
