"""The columns of a table as numbers, and where a cell is none."""

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from realitygap.files.errors import InputError
from realitygap.files.text_table import once
from realitygap.recording.readers.parquet_columns import ParquetColumns
from realitygap.recording.readers.rows import Mask
from realitygap.recording.readers.table_time import DATES, seconds
from realitygap.recording.readers.thousands import pointed
from realitygap.recording.readers.units import SECONDS
from realitygap.recording.streams import Request
from realitygap.trace.trace import Array

Frame = pd.DataFrame | ParquetColumns
"""A table by its columns."""


class Cells:
    """A table whose columns are read as numbers."""

    def __init__(self, path: Path, frame: Frame, request: Request) -> None:
        self.path = path
        self.frame = frame
        self.request = request
        self.dated = False

    def _time(self, name: str) -> Array:
        """A column of numbers or dates as times [s], of dates from the first one."""
        if name in self.frame:
            once(self.path, name, self.frame.attrs)
            column = self.frame[name]
            if (dates := seconds(column)) is not None:
                self._check_parsed(name, column, np.isnan(dates), DATES)
                self.dated = True
                return dates
        return self._column(name, "time", DATES) * SECONDS[self.request.recordings.columns.units.time]

    def _columns(self, names: list[str], key: str, count: int) -> Array:
        if len(names) != count:
            raise InputError(f"{self.request.file}: recordings.columns.{key}: names {len(names)}, expected {count}")
        return np.column_stack([self._column(name, key) for name in names])

    def _column(self, name: str, key: str, expected: str = "a number") -> Array:
        """One column as floats; empty cells are NaN."""
        if name not in self.frame:
            raise InputError(
                f"{self.path}: has no column {name}, named by recordings.columns.{key}; it has {self._listing()}"
            )
        once(self.path, name, self.frame.attrs)
        column = self.frame[name]
        if isinstance(column.dtype, np.dtype) and column.dtype.kind in "iuf":
            return self._finite(name, np.asarray(column, dtype=np.float64))
        told = column
        if self.frame.attrs.get("decimal") == ",":
            told = pointed(column.astype("str"), thousands="note" in self.frame.attrs)
        numbers = pd.to_numeric(told, errors="coerce")  # with one cell that is none, all of a column are text
        self._check_parsed(name, column, numbers.isna().to_numpy(), expected)
        return self._finite(name, numbers.to_numpy(dtype=float))

    def _check_parsed(self, name: str, column: "pd.Series[Any]", unknown: Mask, expected: str) -> None:
        """Make sure that all cells of a column that are not empty were understood."""
        wrong = np.flatnonzero(unknown & column.notna().to_numpy())
        if len(wrong):
            row = int(wrong[0])
            line, cell = self._line(row), column.iloc[row]
            units = row == 0 and len(wrong) == 1 and not any(letter.isdigit() for letter in str(cell))
            way = (
                f"; where line {line} holds units, delete it and say them in recordings.columns.units" if units else ""
            )
            raise InputError(f"{self.path}: {name} is {cell!r} in line {line}, expected {expected}{way}")

    def _finite(self, name: str, value: Array) -> Array:
        """A column (t,) without infinite numbers."""
        wrong = np.flatnonzero(np.isinf(value))
        if len(wrong):
            row = int(wrong[0])
            raise InputError(
                f"{self.path}: {name} is {value[row]} in line {self._line(row)} ({len(wrong)} such values), expected "
                "finite numbers (or an empty cell for none)"
            )
        return value

    def _line(self, row: int) -> int:
        """The line of the file that holds a row."""
        return row + int(self.frame.attrs.get("first_line", 2))

    def _listing(self) -> str:
        return ", ".join(self.frame.columns)
