"""Which column of a table is its time, and in which unit."""

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from realitygap.check.clocks import CERTAIN_SLOW, SLOW
from realitygap.files.errors import InputError
from realitygap.init.names import words
from realitygap.recording.readers.cells import Frame
from realitygap.recording.readers.units import SECONDS

TIME = ("time", "t", "timestamp", "stamp", "clock", "sec", "secs", "seconds", "zeit")
TIME_UNITS = {"s", "sec", "secs", "seconds", "ms", "us", "ns", "stamp"}
WHOLE = {"sec", "secs", "seconds"}
PARTS = {"nanosec", "nanosecs", "nanoseconds", "nsec", "nsecs"}
"""The last words of the two columns of a ROS stamp."""
SINCE_1970 = (1e9, 4e9)
"""s: from 2001 to 2096, in which recordings are stamped."""


def time_column(path: Path, frame: Frame) -> list[str]:
    """The column of time: by its name, or the only one that always rises; or the two of a stamp, s and ns.

    One that rises by ones and has no name of a time counts the rows, as an index that was written with the table.

    Raises:
        InputError: where none is found.
    """
    labels = list(frame.columns)
    stamps = [
        [whole, part]
        for whole in labels
        for part in labels
        if words(whole)[-1:] and words(whole)[-1] in WHOLE and words(part)[-1:] and words(part)[-1] in PARTS
        if words(whole)[:-1] == words(part)[:-1]
    ]
    if stamps:
        return min(stamps, key=lambda names: len(names[0]))
    for option in TIME:
        for label in labels:
            parts = words(label)
            if parts and parts[0] == option and set(parts[1:]) <= TIME_UNITS:
                return [label]
    steps = {label: _numbers(frame[label]).diff().iloc[1:] for label in labels if len(frame) > 2}
    counts = [label for label, step in steps.items() if (step == 1).all()]
    rising = [label for label, step in steps.items() if (step > 0).all() and label not in counts]
    if len(rising) == 1:
        return rising
    rows = f" ({', '.join(counts)} counts the rows)" if counts else ""
    raise InputError(f"{path}: has no column of time; it has {', '.join(labels)}{rows}; expected one named time, in s")


def time_unit(column: "pd.Series[Any]") -> str:
    """The unit that the values of a time show: those since 1970 by their size, others by how far apart they are."""
    values = _numbers(column).dropna().to_numpy(dtype=float)
    if len(values) < 2:
        return "s"
    first, step = abs(values[0]), float(np.median(np.diff(values)))
    for unit, factor in SECONDS.items():
        if SINCE_1970[0] <= first * factor < SINCE_1970[1]:
            return unit
    if step < CERTAIN_SLOW:
        return "s"
    return next((unit for unit, factor in SECONDS.items() if step * factor < SLOW), "s")


def _numbers(column: "pd.Series[Any]") -> "pd.Series[float]":
    """A column as floats; NaN where it holds text."""
    return pd.to_numeric(column, errors="coerce")
