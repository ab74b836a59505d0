"""Which rows of a table are of which stream: loggers merge streams of two rates, with cells empty in between."""

import numpy as np
from numpy.typing import NDArray

from realitygap.recording.lack import Lack
from realitygap.trace.trace import Array

Rows = NDArray[np.intp]
Mask = NDArray[np.bool_]
MEET = 0.5
"""Two streams have rows of their own where fewer of the rarer one's hold both."""
THINNED = 0.1
"""And where more of the commands than this are followed by a row without one: a servo that is off is off for long."""
APART = "commands and states stand in rows of their own: an empty command is none that was sent, and the last one holds"


def rows_apart(state: Mask, command: Mask) -> bool:
    """Whether the rows with a command are those of a stream of its own, so that an empty cell is no servo that is off.

    Args:
        state: which rows hold a measured position. Shape (t,).
        command: which rows say something of a command. Shape (t,).
    """
    fewer = min(int(state.sum()), int(command.sum()))
    if not fewer:
        return False
    steps = np.diff(np.flatnonzero(command))
    thinned = len(steps) > 1 and float(np.mean(steps > 1)) > THINNED
    return bool(thinned or (state & command).sum() < MEET * fewer)


def rows_with(mask: Mask) -> Mask:
    """Which rows hold any of a mask of shape (t, ...). Shape (t,)."""
    return np.asarray(mask.reshape(len(mask), -1).any(axis=1))


def repeats(kept: int, rows: int, *, alike: bool = False) -> Lack:
    """The rows that were not kept, as they repeat the time of another; or all of it, so that nothing is lost."""
    text = f"{rows - kept} rows repeat the time of another and were dropped, of {rows}"
    return Lack("copies" if alike else "repeats", text, 1 - kept / rows)


def out_of_order(time: Array | NDArray[np.int64], what: str = "rows") -> Lack | None:
    """Rows, or what they are called, whose times (t,) are before that of the one before them; None where none is."""
    back = int((np.diff(time) < 0).sum())
    if not back:
        return None
    return Lack("order", f"{back} {what} came out of order and were sorted", back / len(time))


def alike(value: Array, rows: Rows, kept: Rows) -> bool:
    """Whether rows hold no more than those that were kept of them, a value being one number or several each.

    Args:
        value: of all rows of a table. Shape (n, ...).
        rows: in the order of their times. Shape (t,).
        kept: the last ones of every time among them, in their order. Shape (k,).
    """
    ends = np.isin(rows, kept)
    last = kept[np.minimum(np.cumsum(ends) - ends, len(kept) - 1)]
    return bool(np.array_equal(value[rows], value[last], equal_nan=True))


def last_of_each(time: Array) -> Rows:
    """The last of the rows of every time, of times that never go back. Shape (t,)."""
    return np.flatnonzero(np.append(np.diff(time) > 0, True))
