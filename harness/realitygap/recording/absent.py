"""Readings that are absent, as buses lose some: what is left of a stream without them, and what is told of it."""

from collections.abc import Collection
from dataclasses import replace

import numpy as np

from realitygap.files.errors import InputError
from realitygap.recording.commands import PAUSE_PERIODS, PAUSE_SECONDS, usual_period
from realitygap.recording.lack import Lack
from realitygap.recording.streams import Samples
from realitygap.trace.trace import Array

BRIDGED = 2.5
"""Usual periods from known reading to known reading over which one is interpolated: two where one is absent."""

LISTED = 3
"""Pauses that a sentence places; the others it counts."""


def without_absent(samples: Samples, needed: Collection[str]) -> tuple[Samples, list[Lack]]:
    """A stream in which nothing that is needed is absent, and what was left out.

    A sample without a needed signal is left out. What else is absent of a joint is interpolated between its
    neighbours, or stays NaN where they are further apart than `BRIDGED` usual periods or where it never was measured.

    Args:
        samples: the stream.
        needed: the signals without which a sample is of no use.

    Raises:
        InputError: for a value that is infinite, or where fewer than two samples are left.
    """
    _finite(samples)
    missing = {signal: np.isnan(value) for signal, value in samples.signals.items()}
    lost = [m.reshape(len(m), -1).any(axis=1) for signal, m in missing.items() if signal in needed]
    if not any(m.any() for m in missing.values()):
        return samples, []
    told = []
    if (left_out := np.any(lost, axis=0) if lost else np.zeros(len(samples.time), dtype=bool)).any():
        rows = np.flatnonzero(~left_out)
        where = ", ".join(_counted(samples, signal) for signal in missing if signal in needed and missing[signal].any())
        count = f"{left_out.sum()} of {len(left_out)} samples"
        if len(rows) < 2:
            raise InputError(
                f"{samples.source}: {count} are without {where}; expected at least two with all of them: name another "
                "column or topic, or weld a joint that was not measured by robot.hold"
            )
        text = f"{count} are left out, as they are without {where}"
        told.append(Lack("samples", text, float(left_out.mean())))
        samples = _rows(samples, rows)
    signals = {}
    for signal, value in samples.signals.items():
        signals[signal] = value
        if np.isnan(value).any():
            text = f"{samples.source} is without {_counted(samples, signal)}: unknown, but between near readings"
            told.append(Lack("readings", text, float(np.isnan(value).mean(axis=0).max())))
            columns = [_bridged(samples.time, column) for column in value.reshape(len(value), -1).T]
            signals[signal] = np.column_stack(columns).reshape(value.shape)
    return replace(samples, signals=signals), told


def holes(time: Array) -> list[Lack]:
    """Where a regular stream pauses for as long as commands do that are none (`commands.in_force`).

    Buses lose a sample: of 274 recordings of seven machines no pause is longer than 1.8 periods.
    """
    period = usual_period(time)
    if period is None:
        return []
    long = np.flatnonzero(np.diff(time) > max(PAUSE_PERIODS * period, PAUSE_SECONDS))
    if not len(long):
        return []
    where = ", ".join(f"from {time[i]:.3f} to {time[i + 1]:.3f} s" for i in long[:LISTED])
    more = f" and in {len(long) - LISTED} more pauses" if len(long) > LISTED else ""
    part = float(np.diff(time)[long].sum() / (time[-1] - time[0]))
    return [Lack("pause", f"no samples {where}{more}, which come every {1e3 * period:.3g} ms otherwise", part)]


def _counted(samples: Samples, signal: str) -> str:
    """Of which joints a signal is absent, and how often."""
    value = samples.signals[signal]
    absent = np.isnan(value).reshape(len(value), -1).sum(axis=0)
    if not samples.joints or len(absent) != len(samples.joints):
        return f"the {signal} ({absent.max()})"
    named = [f"{joint} ({count})" for joint, count in zip(samples.joints, absent, strict=True) if count]
    return f"the {signal} of {', '.join(named)}"


def _rows(samples: Samples, rows: "np.ndarray[tuple[int], np.dtype[np.intp]]") -> Samples:
    return replace(
        samples,
        time=samples.time[rows],
        signals={signal: value[rows] for signal, value in samples.signals.items()},
        receive=None if samples.receive is None else samples.receive[rows],
    )


def _bridged(time: Array, column: Array) -> Array:
    """A reading with those that are absent between two near ones on the line between them. Shape (m,)."""
    known = np.flatnonzero(np.isfinite(column))
    period = usual_period(time[known])
    if period is None or len(known) == len(column):
        return column
    absent = np.flatnonzero(np.isnan(column))
    after = np.searchsorted(known, absent)
    inside = (after > 0) & (after < len(known))
    absent, after = absent[inside], after[inside]
    near = time[known[after]] - time[known[after - 1]] <= BRIDGED * period
    out = column.copy()
    out[absent[near]] = np.interp(time[absent[near]], time[known], column[known])
    return out


def _finite(samples: Samples) -> None:
    for name, value in samples.signals.items():
        bad = np.argwhere(np.isinf(value))
        if len(bad):
            row = bad[0]
            joint = f" of joint {samples.joints[row[1]]}" if samples.joints and value.ndim == 2 else ""
            raise InputError(
                f"{samples.source}: {name}{joint} is {value[tuple(row)]} in sample {row[0] + 1} of {len(value)} "
                f"({len(bad)} such values), expected finite numbers (or NaN for none)"
            )
