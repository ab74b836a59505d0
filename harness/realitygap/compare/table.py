"""The result table `gaps.csv`: one row per joint and signal, sorted, the same for every command."""

import csv
import hashlib
import io
import json
from collections.abc import Iterable
from dataclasses import asdict, dataclass, fields
from pathlib import Path

import numpy as np
import pandas as pd

from realitygap.compare.gap import Difference
from realitygap.files.errors import InputError
from realitygap.files.spreadsheet import as_meant, as_words

SIGNIFICANT = 6
"""Digits in tables: more than any sensor has, and few enough that rounding does not show as a change."""


@dataclass(frozen=True)
class Cell:
    """What one simulation of the matrix stands for: the key columns of the table."""

    scenario: str
    robot_revision: str
    engine: str
    engine_version: str
    ground: str
    recorded_ground: str
    step_rate: float
    solver_iterations: int | None
    overrides: str
    recording: str
    use: str


@dataclass(frozen=True)
class Row(Cell):
    """One joint and signal of one cell. A failed cell has rows with infinite gaps and the reason in `note`."""

    joint: str
    group: str
    signal: str
    unit: str
    mean_abs: float
    median_abs: float
    p95_abs: float
    max_abs: float
    noise_floor: float
    numerical_floor: float
    outcome: str
    note: str


COLUMNS = [f.name for f in fields(Row)]
CELL = [f.name for f in fields(Cell)]


LONGEST_NAME = 120
"""Bytes of the readable part of a file name: file systems take 255 in all."""


def file_name(words: str) -> str:
    """Words as a part of a file name that every file system takes."""
    safe = "".join(c if c.isalnum() or c in "-_." else "-" for c in words)
    return safe.encode("utf-8", "ignore")[:LONGEST_NAME].decode("utf-8", "ignore")


def slug(cell: Cell) -> str:
    """A file name that is the same for the same cell: readable, with a hash of the whole key."""
    key = json.dumps([str(v) for v in vars(cell).values()])
    readable = "_".join(p for p in (cell.engine, cell.recording or cell.scenario) if p)
    return f"{file_name(readable)}_{hashlib.sha256(key.encode('utf-8', 'replace')).hexdigest()[:8]}"


def row(cell: Cell, difference: Difference, noise: float, numerical: float, note: str = "") -> Row:
    """The row of one difference; floors in the unit of the difference."""
    values = difference.values if difference.values.size else np.array([np.nan])
    return Row(
        **asdict(cell),
        joint=difference.joint,
        group=difference.group,
        signal=difference.signal,
        unit=difference.unit,
        mean_abs=float(np.mean(values)),
        median_abs=float(np.median(values)),
        p95_abs=float(np.percentile(values, 95)),
        max_abs=float(np.max(values)),
        noise_floor=noise,
        numerical_floor=numerical,
        outcome="ok",
        note=note,
    )


def failed(cell: Cell, difference: Difference, noise: float, outcome: str, note: str) -> Row:
    """The row of a joint and signal that could not be simulated."""
    inf = float("inf")
    return Row(
        **asdict(cell),
        joint=difference.joint,
        group=difference.group,
        signal=difference.signal,
        unit=difference.unit,
        mean_abs=inf,
        median_abs=inf,
        p95_abs=inf,
        max_abs=inf,
        noise_floor=noise,
        numerical_floor=float("nan"),
        outcome=outcome,
        note=note,
    )


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


EXCLUDED = "left out of the means"
