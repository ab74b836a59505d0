"""Single readings that no motion of the joint explains: garbled on the bus, and taken out when a recording is read."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from realitygap.recording.quantum import quantum
from realitygap.trace.trace import Array, Trace

FAR = 10.0
"""How many times further than anything near it a reading must be to be no motion."""
USUAL = 0.99
"""The share of a joint's steps from reading to reading that are taken as usual."""
UNITS = {"position": "in rad, of a slide in m", "velocity": "in rad/s, of a slide in m/s"}
SHOWN = 3
"""Outliers that a sentence lists."""


@dataclass(frozen=True)
class Outlier:
    """A reading that was taken out: of which joint and signal, when [s], and what it was [rad or m, or per s]."""

    joint: str
    signal: str
    time: float
    value: float


def told(outliers: Sequence[Outlier]) -> dict[tuple[str, str], str]:
    """A sentence for every joint and signal with outliers."""
    readings: dict[tuple[str, str], list[str]] = {}
    for o in outliers:
        readings.setdefault((o.joint, o.signal), []).append(f"{o.value:.4g} at {o.time:.3f} s")
    return {
        (joint, signal): f"{len(all_)} {signal} reading{'s' * (len(all_) > 1)} of {joint} jump{'s' * (len(all_) == 1)} "
        f"far away and back ({', '.join(all_[:SHOWN])}{', ...' * (len(all_) > SHOWN)}) {UNITS[signal]}: the bus, not "
        "the robot; the mean of the neighbours is taken"
        for (joint, signal), all_ in readings.items()
    }


def without_outliers(trace: Trace) -> tuple[Trace, tuple[Outlier, ...]]:
    """A trace with the mean of their neighbours in place of outliers, and what those were.

    An outlier is a reading that jumps away and back by more than `FAR` times what is usual for its joint and signal.
    For a velocity, the positions before and after must also contradict it as much: an impact is fast, but it moves.
    """
    if trace.position is None or len(trace.time) < 3:
        return trace, ()
    mended, found = trace, []
    for signal in ("position", "velocity"):
        value = getattr(trace, signal)
        if value is None:
            continue
        alone, far = _jumps(value)
        if signal == "velocity":
            least, lasted = 2 * _resolution(trace.position), (trace.time[2:] - trace.time[:-2]) / 2
            for column, v, q in zip(alone.T, value.T, trace.position.T, strict=True):
                column &= np.abs(v[1:-1]) * lasted > FAR * (np.abs(q[2:] - q[:-2]) + least)
        if not alone.any():
            continue
        instead = value.copy()
        garbled = np.zeros(value.shape, dtype=bool)
        for joint in np.flatnonzero(alone.any(axis=0)):
            bad = garbled[:, joint]
            bad[1:-1] = alone[:, joint]
            _keep_between(bad, value[:, joint], far[joint])
            rows = np.arange(len(bad))
            instead[bad, joint] = np.interp(rows[bad], rows[~bad], value[~bad, joint])
        rows, columns = np.nonzero(garbled)
        mended = replace(mended, **{signal: instead})
        found += [
            Outlier(trace.joints[j], signal, float(trace.time[k]), float(value[k, j]))
            for k, j in zip(rows, columns, strict=True)
        ]
    return (mended, tuple(found)) if found else (trace, ())


def _keep_between(garbled: NDArray[np.bool_], value: Array, far: float) -> None:
    """Take sound readings of a joint out of those that are garbled (t,), in place: between two of these, one jumps away
    and back, too, but is near the line between the sound ones around.
    """
    starts, ends = (np.flatnonzero(garbled[1:-1] & ~beside) + 1 for beside in (garbled[:-2], garbled[2:]))
    for a, b in zip(starts, ends, strict=True):
        if b > a:
            line = np.linspace(value[a - 1], value[b + 1], b - a + 3)[1:-1]
            garbled[a : b + 1] &= np.abs(value[a : b + 1] - line) > far


def _jumps(value: Array) -> tuple[NDArray[np.bool_], Array]:
    """Which inner readings jump away and back by far more than usual (t - 2, n), and how far that is (n,)."""
    least, out = _resolution(value), np.empty((len(value) - 2, value.shape[1]), dtype=bool)
    limits = np.empty(value.shape[1])
    for j, (column, alone) in enumerate(zip(value.T, out.T, strict=True)):  # one at a time: recordings are long
        steps = np.diff(column)
        sizes = np.abs(steps)
        known = sizes[np.isfinite(sizes)]
        far = FAR * max(np.quantile(known, USUAL), least) if len(known) else np.inf
        back = (steps[:-1] < 0) != (steps[1:] < 0)  # by their product, garbled readings overflow
        alone[:], limits[j] = back & (np.minimum(sizes[:-1], sizes[1:]) > far), far
    return out, limits


def _resolution(value: Array) -> float:
    """The finest quantum of the sensors: a joint at rest does not show its own. Shape (t, n)."""
    steps = quantum(value)
    return float(steps[steps > 0].min()) if steps.any() else 0.0
