"""The table as the page wants it: columns of small numbers that point into lists of names."""

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from realitygap.compare.row import EXCLUDED
from realitygap.page.style import AXES, SIGNALS, axis_value, engine_color, engine_dashes, engine_label
from realitygap.report.folder import Results, cell_key
from realitygap.report.groups import groups

DIGITS = 6
"""Significant digits of numbers in the page, three more than it prints: what is rounded twice, or the mean of what was
rounded, is the number that the terminal tells."""
NUMBERS = {
    "mean": "mean_abs",
    "median": "median_abs",
    "p95": "p95_abs",
    "max": "max_abs",
    "noise": "noise_floor",
    "numerical": "numerical_floor",
}


def payload(results: Results) -> dict[str, Any]:
    """Everything the page's script draws from, but the curves."""
    gaps = results.gaps
    joints = sorted(gaps["joint"].unique())
    units = sorted(gaps["unit"].unique())
    signals = list(SIGNALS)
    found = groups(gaps)
    number_of = {cell_key(r): i for i, r in enumerate(results.cells.to_dict("records"))}
    return {
        "axes": [_axis(a, values) for a, values in results.axes.items()],
        "engines": [
            {
                "label": engine_label(e),
                "color": engine_color(e, results.engines),
                "dashes": engine_dashes(e, results.engines),
            }
            for e in results.engines
        ],
        "signals": [{"key": s, "label": SIGNALS[s]} for s in signals],
        "joints": joints,
        "units": units,
        "groups": found,
        "cells": _cells(results),
        "rows": {
            "cell": [number_of[cell_key(r)] for r in gaps.to_dict("records")],
            "joint": _indices(gaps["joint"], joints),
            "signal": _indices(gaps["signal"], signals),
            "group": _indices(gaps["group"], found),
            "unit": _indices(gaps["unit"], units),
            "excluded": [int(n == EXCLUDED) for n in gaps["note"]],
            **{name: [_short(v) for v in gaps[column]] for name, column in NUMBERS.items()},
        },
    }


def _axis(axis: str, values: list[Any]) -> dict[str, Any]:
    texts = [{"text": axis_value(axis, v), "value": _plain(v)} for v in values]
    return {"key": axis, "label": AXES.get(axis, axis), "values": texts}


def _cells(results: Results) -> list[dict[str, Any]]:
    out = []
    for record in results.cells.to_dict("records"):
        at = []
        for axis, values in results.axes.items():
            value = record[axis]
            at.append(values.index("" if value is pd.NA or value is None else value))
        whole = results.traces.get(cell_key(record))
        viewed = whole.with_suffix(".mcap") if whole else None
        out.append(
            {
                "at": at,
                "outcome": record["outcome"],
                "note": record["note"],
                "speed": _short(record.get("real_time_factor", float("nan"))),
                "wall": _short(record.get("wall_seconds", float("nan"))),
                "curves": whole.stem if whole else None,
                "trace": _link(viewed, results.folder) if viewed and viewed.is_file() else None,
                "whole": _link(whole, results.folder) if whole else None,
            }
        )
    return out


def _link(path: Path, folder: Path) -> str:
    return path.relative_to(folder).as_posix()


def _indices(column: "pd.Series[str]", names: list[str]) -> list[int]:
    place = {name: i for i, name in enumerate(names)}
    return [place[v] for v in column]


def _short(value: float) -> float | None:
    """Few digits; None for what is unknown or infinite, which JSON cannot say."""
    return float(f"{value:.{DIGITS}g}") if np.isfinite(value) else None


def _plain(value: Any) -> Any:
    return value.item() if isinstance(value, np.generic) else value
