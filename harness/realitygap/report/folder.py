"""A result folder, read: everything that page and figures are made of."""

import json
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import pandas as pd
from realitygap_engines.errors import in_a_line

from realitygap.compare.row import CELL, Cell
from realitygap.compare.table import means, read_gaps
from realitygap.compare.traces import FOLDER, cell_of_traces
from realitygap.files.errors import InputError
from realitygap.files.result_kind import command_of, held_results
from realitygap.page.style import AXES, SIGNALS
from realitygap.report.groups import SECTIONS, by_kind
from realitygap.report.manifest import read_manifest

FLOOR_COLUMNS = ["noise_floor", "numerical_floor"]


@dataclass(frozen=True)
class Results:
    """What a run or a matrix left behind.

    Attributes:
        folder: where it lies.
        gaps: `gaps.csv`, with one more column per overridden key, and the group as `groups.by_kind` tells it.
        means: means over joints (see `realitygap.compare.table.means`), with the same columns.
        cells: one row per cell: the key columns, outcome, note, and where known `real_time_factor` and
            `wall_seconds`.
        axes: what tells cells apart -> its values in order; every axis that the table has, also those with one value.
        traces: key of a cell -> the Parquet file with its traces.
        manifest: `manifest.json`, empty where there is none.
    """

    folder: Path
    gaps: pd.DataFrame
    means: pd.DataFrame
    cells: pd.DataFrame
    axes: dict[str, list[Any]]
    traces: dict[tuple[str, ...], Path]
    manifest: dict[str, Any]

    @property
    def engines(self) -> list[str]:
        """The engines in the table."""
        return [str(e) for e in self.axes.get("engine", [])]

    @property
    def varying(self) -> list[str]:
        """Axes with more than one value."""
        return [a for a, values in self.axes.items() if len(values) > 1]

    @property
    def virtual(self) -> bool:
        """Whether the recordings come from a simulation."""
        return bool(self.manifest.get("virtual"))


def read_folder(folder: Path) -> Results:
    """Read a result folder.

    Raises:
        InputError: where it holds no result table, or a file of it is damaged.
    """
    path = folder / "gaps.csv"
    if not path.is_file():
        expected = "expected a folder written by `realitygap run` or `matrix`"
        if held := held_results(folder):
            raise InputError(
                f"{folder}: holds the result of `{held[0]}`, which writes its page itself, of simulations that are not "
                f"kept; {expected}; `{command_of(folder, held[0])}` makes result and page anew"
            )
        raise InputError(f"{folder}: found no gaps.csv; {expected}")
    raw = read_gaps(path)
    _check(path, raw)
    raw = by_kind(raw)
    manifest = read_manifest(folder)
    paths = sorted((folder / FOLDER).glob("*.parquet"))
    listed = manifest.get("traces")
    if listed is not None:  # others are somebody else's
        paths = [p for p in paths if p.stem in listed]
    traces = {cell_key(vars(cell_of_traces(p))): p for p in paths}
    cells = _cells(folder, raw, traces)
    keys = _override_keys(cells)
    return Results(
        folder=folder,
        gaps=_expanded(raw, keys),
        means=_expanded(means(raw), keys),
        cells=_expanded(cells, keys),
        axes=_axes(_expanded(cells, keys), keys),
        traces=traces,
        manifest=manifest,
    )


def _check(path: Path, raw: pd.DataFrame) -> None:
    """Make sure that a table's words are those that a run writes, which its types do not tell."""
    for column, known in (("signal", SIGNALS), ("group", SECTIONS)):
        strange = sorted(set(raw[column]) - set(known))
        if strange:
            raise InputError(f"{path}: {column}: found {strange[0]!r}; expected one of {', '.join(known)}")
    for text in raw["overrides"].unique():
        try:
            good = not text or isinstance(json.loads(text), dict)
        except (ValueError, RecursionError):
            good = False
        if not good:
            raise InputError(f"{path}: overrides: found {text[:80]!r}; expected a JSON object of scenario keys")


def cell_key(record: Any) -> tuple[str, ...]:
    """The key of a cell as text, the same from every file it is read from."""
    return tuple(_text(record[c]) for c in CELL)


def _text(value: Any) -> str:
    if value is None or value is pd.NA or (isinstance(value, float) and value != value):
        return ""
    return f"{value:g}" if isinstance(value, float) else str(value)


def _cells(folder: Path, raw: pd.DataFrame, traces: dict[tuple[str, ...], Path]) -> pd.DataFrame:
    """All cells: those of the table, and those that have only traces because nothing was measured."""
    cells = raw[[*CELL, "outcome", "note"]].drop_duplicates(CELL)
    cells.loc[cells["outcome"] == "ok", "note"] = ""
    known = {cell_key(r) for r in cells.to_dict("records")}
    only = [dict(zip(CELL, key, strict=True)) | {"outcome": "ok", "note": ""} for key in traces if key not in known]
    if only:
        extra = pd.DataFrame(only)
        extra["step_rate"] = extra["step_rate"].astype(float)
        extra["solver_iterations"] = pd.to_numeric(extra["solver_iterations"]).astype("Int64")
        cells = pd.concat([cells, extra], ignore_index=True) if len(cells) else extra
    path = folder / "timings.csv"
    if not path.is_file() or not path.read_bytes().strip():
        return cells.reset_index(drop=True)
    text: dict[str, Any] = {f.name: str for f in fields(Cell) if f.type in (str, "str")}
    columns = ("real_time_factor", "wall_seconds")
    numbers: dict[str, Any] = dict.fromkeys((*columns, "step_rate"), float)
    try:
        timings = pd.read_csv(path, dtype=text | numbers, keep_default_na=False, na_values=[""])
        timed = {cell_key(r): r for r in timings.to_dict("records")}
        if timings[[*columns, "step_rate"]].isna().any(axis=None):
            raise ValueError("a row of it is cut off")
    except Exception as error:  # pandas raises many kinds for a broken file
        raise InputError(f"{path}: is not a table of timings ({in_a_line(error)}); take it away or run again") from None
    for column in columns:
        cells[column] = [timed.get(cell_key(r), {}).get(column, float("nan")) for r in cells.to_dict("records")]
    return cells.reset_index(drop=True)


def _override_keys(cells: pd.DataFrame) -> list[str]:
    keys: dict[str, None] = {}
    for text in cells["overrides"].unique():
        keys |= dict.fromkeys(json.loads(text) if text else {})
    return sorted(keys)


def _expanded(frame: pd.DataFrame, keys: list[str]) -> pd.DataFrame:
    """The table with a column per overridden key; "" where a cell does not override it."""
    frame = frame.copy()
    for key in keys:
        parsed = {t: json.loads(t).get(key, "") if t else "" for t in frame["overrides"].unique()}
        values = frame["overrides"].map(parsed)
        frame[key] = values.map(lambda v: v if isinstance(v, str | int | float) else json.dumps(v))
    return frame


def _axes(cells: pd.DataFrame, override_keys: list[str]) -> dict[str, list[Any]]:
    """Axes and their values. What follows from the recording alone, as its gain does, is no axis of its own."""
    out: dict[str, list[Any]] = {}
    for axis in [*(a for a in AXES if a != "overrides"), *override_keys]:
        values = list(dict.fromkeys(cells[axis].astype(object).where(cells[axis].notna(), "")))
        if axis in override_keys and len(values) > 1:
            per_recording = cells.groupby(["scenario", "recording"])[axis].nunique()
            if per_recording.max() == 1:
                continue
        out[axis] = sorted(values, key=lambda v: (isinstance(v, str), v))
    return out
