"""The figures of a result folder, as files for papers and slides: `figures/*.svg`, made from table and traces alone."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from realitygap.compare.table import file_name
from realitygap.compare.traces import CellTraces, read_traces
from realitygap.files.errors import spared
from realitygap.page.style import AXES, SIGNALS, axis_value, engine_color, engine_dashes, engine_label, unit_label
from realitygap.report.curves import boxes, series, thinned
from realitygap.report.draw import BoxSet, Curve, draw_boxes, draw_curves
from realitygap.report.folder import Results, cell_key, read_folder
from realitygap.trace.trace import Array

MOST = 6
"""Conditions that get figures of their own; a larger matrix has its page."""
CHOSEN = 4
"""Joints whose curves are drawn: those with the largest gap."""
SAMPLES = 500
"""Samples of a curve: as many as a panel has pixels."""
CONDITION = [a for a in AXES if a != "engine"]


def write_figures(folder: Path, out: Path | None = None, failures: list[str] | None = None) -> list[Path]:
    """Write box plots per joint and curves of the joints with the largest gaps. Returns the files.

    Box plots stand one above the other: the engines for every condition, and for every engine the revisions.

    Args:
        folder: the result folder.
        out: where to write (default: there).
        failures: takes sentences on figures that could not be drawn.

    Raises:
        InputError: where the folder holds no result table, or a file of it is damaged.
    """
    results = read_folder(folder)
    out, failures = out or folder, [] if failures is None else failures
    cells = results.cells.to_dict("records")
    written: list[Path] = []
    for condition, group in list(_by(cells, CONDITION).items())[:MOST]:
        name = _name(dict(zip(CONDITION, condition, strict=True)), results)
        traces = {str(c["engine"]): found for c in group if (found := _traces(c, results))}
        sets = [_set(c, engine_label(str(c["engine"])), results, traces.get(str(c["engine"]))) for c in group]
        with spared(f"figures of {name}", failures):
            written += _box_files(out, results, name, sets)
            if traces:
                written += _curve_files(out, results, name, traces, sets)
    if len(results.axes["robot_revision"]) > 1:
        others = [a for a in AXES if a != "robot_revision"]
        for condition, group in list(_by(cells, others).items())[:MOST]:
            name = _name(dict(zip(others, condition, strict=True)), results)
            if len(group) > 1:
                sets = [_set(c, str(c["robot_revision"]), results, _traces(c, results)) for c in group]
                with spared(f"figures of revisions {name}", failures):
                    written += _box_files(out, results, f"revisions {name}", sets)
    return written


def _by(cells: Sequence[dict[Any, Any]], axes: Sequence[str]) -> dict[tuple[str, ...], list[dict[Any, Any]]]:
    out: dict[tuple[str, ...], list[dict[Any, Any]]] = {}
    for cell in cells:
        out.setdefault(tuple(str(cell[a]) for a in axes), []).append(cell)
    return out


def _name(condition: dict[str, str], results: Results) -> str:
    """What tells this condition from the others, in words; the recording or scenario where nothing does."""
    parts = []
    for axis, value in condition.items():
        if axis == "overrides":
            parts += [f"{k.split('.')[-1]} {v}" for k, v in json.loads(value or "{}").items() if k in results.varying]
        elif axis in results.varying:
            parts.append(axis_value(axis, value))
    return " ".join(parts) or condition["recording"] or condition["scenario"]


def _traces(cell: dict[Any, Any], results: Results) -> CellTraces | None:
    path = results.traces.get(cell_key(cell))
    return read_traces(path) if path else None


def _set(cell: dict[Any, Any], label: str, results: Results, traces: CellTraces | None) -> BoxSet:
    failed = "" if cell["outcome"] == "ok" else str(cell["outcome"])
    color = engine_color(str(cell["engine"]), results.engines)
    return BoxSet(label, color, boxes(traces) if traces else {}, failed)


def _box_files(out: Path, results: Results, name: str, sets: list[BoxSet]) -> list[Path]:
    written = []
    for signal in SIGNALS:
        units = sorted(results.gaps.loc[results.gaps["signal"] == signal, "unit"].unique())
        shown = " or ".join(unit_label(u) for u in units)
        written.append(draw_boxes(_path(out, f"boxes {signal} {name}"), sets, signal, shown, name))
    return [path for path in written if path]


def _curve_files(
    out: Path, results: Results, name: str, traces: dict[str, CellTraces], sets: Sequence[BoxSet]
) -> list[Path]:
    """The curves of the joints with the largest gaps, measured and in every engine, in the first signal there is."""
    first = next(iter(traces.values()))
    named = series(first.simulated, first)
    signal = next((s for s in SIGNALS if s in named), None)
    if signal is None:
        return []
    joints = list(named[signal])
    boxed = [s.boxes[signal] for s in sets if signal in s.boxes]
    if boxed and all(j in boxed[0] for j in joints):
        joints = sorted(joints, key=lambda j: -max(b[j][3] for b in boxed if j in b))
    joints = joints[:CHOSEN]
    curves = []
    measured: dict[str, Array] = {}
    for engine, cell in traces.items():
        clock = thinned(cell, SAMPLES)
        ours = series(cell.simulated.at(clock), cell)[signal]
        if cell.measured is not None:
            theirs = series(cell.measured.at(clock), cell).get(signal, {})
            measured = {j: theirs[j][1] for j in joints if j in theirs}
        color, dashes = engine_color(engine, results.engines), engine_dashes(engine, results.engines)
        shown = {j: ours[j][1] for j in joints}
        curves.append(Curve(engine_label(engine), color, dashes, clock - clock[0], shown))
    failed = ", ".join(f"{s.label}: {s.failed}" for s in sets if s.failed)
    units = {j: named[signal][j][0] for j in joints}
    title = f"{name} ({failed})" if failed else name
    return [draw_curves(_path(out, f"curves {signal} {name}"), curves, measured, units, signal, title)]


def _path(folder: Path, name: str) -> Path:
    return folder / "figures" / f"{file_name(name)}.svg"
