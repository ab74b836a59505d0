"""From a stream of commands to the command that was in force: held between messages, absent while the stream pauses."""

import numpy as np
from numpy.typing import NDArray

from realitygap.trace.trace import Array

PAUSE_PERIODS = 20.0
PAUSE_SECONDS = 0.2


def usual_period(time: Array) -> float | None:
    """The period [s] of a regular stream; None where messages come when something happens, or are too few to tell.

    Regular means that nine of ten messages follow within twice the median time.
    """
    if len(time) < 10:
        return None
    steps = np.diff(time)
    median = float(np.median(steps))
    return median if np.quantile(steps, 0.9) <= 2.0 * median else None


def in_force(
    time: Array, value: Array, present: NDArray[np.bool_] | None, state_time: Array, joints: tuple[str, ...]
) -> tuple[Array, Array, list[str]]:
    """The command in force, as steps: held from each time until the next.

    A controller that is switched off falls silent: a regular stream that is silent for more than 20 of its periods (at
    least 0.2 s), while joint states keep coming, gives no command from one period after its last message on. A stream
    without a usual period is held, however long. The first command also holds before it, back to the first joint
    state, where that is nearer than the same limit.

    Args:
        time: Shape (m,) [s].
        value: Shape (m, n); NaN is an explicit "no command".
        present: Shape (m, n), which joints a message named; the others keep theirs. None: all.
        state_time: Shape (t,), when joint states were measured [s].
        joints: n names.

    Returns:
        Times (k,), commands (k, n) with NaN where none is in force, and sentences on what was decided.
    """
    named = np.broadcast_to(True, value.shape) if present is None else present
    silent: dict[tuple[float, float], list[str]] = {}
    early: list[tuple[int, float]] = []
    for j, joint in enumerate(joints):
        own = time[named[:, j]]
        period = usual_period(own)
        if not len(own):
            continue
        limit = PAUSE_SECONDS if period is None else max(PAUSE_PERIODS * period, PAUSE_SECONDS)
        if state_time[0] < own[0] <= state_time[0] + limit:
            early.append((j, own[0]))
        for pause in [] if period is None else _pauses(own, period, limit, state_time):
            silent.setdefault(pause, []).append(joint)

    starts = np.array([start for start, _ in silent] + ([float(state_time[0])] if early else []))
    grid = np.unique(np.concatenate([time, starts]))
    index = np.searchsorted(time, grid, side="right") - 1
    out = np.empty((len(grid), len(joints)))
    for j, column in enumerate(out.T):  # a column at a time: recordings are long
        last = np.maximum.accumulate(np.where(named[:, j], np.arange(len(time)), -1))[np.maximum(index, 0)]
        column[:] = np.where((index >= 0) & (last >= 0), value[np.maximum(last, 0), j], np.nan)
    for j, start in early:
        out[grid < start, j] = value[np.flatnonzero(named[:, j])[0], j]
    notes = []
    for (start, end), names in sorted(silent.items()):
        off = (grid >= start) & (grid < end)
        for name in names:
            out[off, joints.index(name)] = np.nan
        until = "to the end" if np.isinf(end) else f"until {end:.3f} s"
        who = "all joints" if len(names) == len(joints) else ", ".join(names)
        notes.append(f"no command for {who} from {start:.3f} s {until}: the stream is silent, the servo taken as off")
    never = [joint for j, joint in enumerate(joints) if not named[:, j].any()]
    if never:
        notes.append(f"never commanded: {', '.join(never)}")
    return grid, out, notes


def _pauses(time: Array, period: float, limit: float, state_time: Array) -> list[tuple[float, float]]:
    """Start and end [s] of every silence of a regular stream during which joint states keep coming."""
    ends = np.append(time[1:], np.inf)
    reach = np.minimum(ends, state_time[-1])
    long = np.flatnonzero(reach - time > limit)
    seen = np.searchsorted(state_time, reach[long]) - np.searchsorted(state_time, time[long], side="right")
    return [(float(time[i] + period), float(ends[i])) for i, n in zip(long, seen, strict=True) if n > 3]


def held_at(command_time: Array, command: Array, time: Array) -> Array:
    """The command in force at other times. Shape (t, n); NaN before the first."""
    index = np.searchsorted(command_time, time, side="right") - 1
    out = np.asarray(command, dtype=float)[np.maximum(index, 0)]
    out[index < 0] = np.nan
    return out
