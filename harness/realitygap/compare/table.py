"""The result table `gaps.csv`: one row per joint and signal, sorted, the same for every command."""

import csv
import io
from collections.abc import Iterable
from dataclasses import asdict, fields
from pathlib import Path

import numpy as np
import pandas as pd

from realitygap.compare.row import COLUMNS, EXCLUDED, Cell, Row
from realitygap.files.errors import InputError
from realitygap.files.spreadsheet import as_meant, as_words

SIGNIFICANT = 6
"""Digits in tables: more than any sensor has, and few enough that rounding does not show as a change."""


def table(rows: Iterable[Row]) -> pd.DataFrame:
    """The sorted table."""
    frame = pd.DataFrame([asdict(r) for r in rows], columns=COLUMNS)
    frame["solver_iterations"] = frame["solver_iterations"].astype("Int64")
    keys = [c for c in COLUMNS if c not in ("mean_abs", "median_abs", "p95_abs", "max_abs", "note")]
    return frame.sort_values(keys, kind="stable", na_position="first", ignore_index=True)


def to_csv(frame: pd.DataFrame) -> str:
    """The table as text: fixed digits, so that a difference between two files means that physics moved."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(frame.columns)
    for record in frame.itertuples(index=False):
        writer.writerow([_text(v) for v in record])
    return out.getvalue()


def _text(value: object) -> str:
    if value is None or value is pd.NA:
        return ""
    if isinstance(value, float | np.floating):
        return "" if np.isnan(value) else f"{value:.{SIGNIFICANT}g}"
    return as_words(str(value))


def read_gaps(path: Path) -> pd.DataFrame:
    """A `gaps.csv` as a table with the types of `Row`.

    Raises:
        InputError: for a file that is not one.
    """
    text = {f.name: str for f in fields(Row) if f.type is str}
    numbers = {f.name: float for f in fields(Row) if f.type is float}
    types = text | numbers | {"solver_iterations": "Int64"}
    try:
        frame = pd.read_csv(path, dtype=types, keep_default_na=False, na_values=[""])
    except Exception as error:  # pandas raises many kinds for a broken file
        raise InputError(f"{path}: is not a table of gaps ({' '.join(str(error).split())})") from None
    missing = [c for c in COLUMNS if c not in frame]
    if missing:
        raise InputError(f"{path}: has no column {', '.join(missing)}; expected a table that realitygap wrote")
    frame[list(text)] = frame[list(text)].fillna("").map(as_meant)
    return frame


def means(frame: pd.DataFrame) -> pd.DataFrame:
    """Means over joints, as the thesis takes them: of the mean absolute difference, per cell, group and signal.

    Joints that were left out by the scenario do not count. Floors are averaged alike.
    """
    kept = frame[frame["note"] != EXCLUDED]
    keys = [*[f.name for f in fields(Cell)], "group", "signal", "unit"]
    columns = ["mean_abs", "noise_floor", "numerical_floor"]
    grouped = kept.groupby(keys, dropna=False, sort=True)
    out: pd.DataFrame = grouped[columns].mean().join(grouped.size().rename("joints")).reset_index()
    return out
