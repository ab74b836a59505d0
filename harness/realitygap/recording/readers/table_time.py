"""The time of a table: numbers or dates, of rows that may have come a little out of order."""

import re
from typing import Any

import numpy as np
import pandas as pd

from realitygap.recording.readers.rows import Rows
from realitygap.trace.trace import Array

ISO = re.compile(r"\s*\d{4}-\d{2}-\d{2}[T ]\d{2}:\d{2}")
"""How a date with a time of day begins in ISO 8601."""
DATES = (
    "a number, or a date as 2024-03-05T10:00:00.010 (ISO 8601), which pandas.to_datetime(column, dayfirst=True) makes "
    "of 05.03.2024, and a spreadsheet the cell format yyyy-mm-dd\\Thh:mm:ss.000"
)
"""What a time may be, and how other dates become it."""
LATE = 10.0
"""Usual periods by which a row may be late, as one from a buffer; a clock that was set back is so by more."""


def seconds(column: "pd.Series[Any]") -> Array | None:
    """A column of dates or durations as times from its first one [s], NaN where it has none; None for other columns.
    Text counts as dates where its first cell is one in ISO 8601, and what is none among them is NaN.
    """
    if column.dtype.kind not in "Mm":
        first = next(iter(column.dropna()), None)
        if not isinstance(first, str) or not ISO.match(first):
            return None
        pointed = column.astype("str").str.strip().str.replace(",", ".")
        column = pd.to_datetime(pointed, format="ISO8601", utc=True, errors="coerce")
    known = column.dropna()
    if not len(known):
        return np.full(len(column), np.nan)
    return np.asarray((column - known.iloc[0]).dt.total_seconds(), dtype=float)


def rows_by_time(time: Array) -> tuple[Rows, int | None]:
    """The rows in the order of their times (t,), and the first one that is late by more than `LATE`; None: none is."""
    steps = np.diff(time)
    if not (steps < 0).any():
        return np.arange(len(time)), None
    late = np.maximum.accumulate(time)[:-1] - time[1:]
    usual = float(np.median(steps[steps > 0])) if (steps > 0).any() else 0.0
    far = np.flatnonzero(late > LATE * usual)
    return np.argsort(time, kind="stable"), int(far[0]) + 1 if len(far) else None
