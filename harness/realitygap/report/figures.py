"""The figures of a result folder, as files for papers and slides: `figures/*.svg`, made from the curve files alone."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from realitygap.page.style import AXES, SIGNALS, axis_value, engine_color, engine_dashes, engine_label, unit_label
from realitygap.report.curves import read_curves, unpack
from realitygap.report.draw import BoxSet, Curve, draw_boxes, draw_curves
from realitygap.report.folder import Results, cell_key, read_folder

MOST = 6
"""Conditions that get figures of their own; a larger matrix has its page."""
CHOSEN = 4
"""Joints whose curves are drawn: those with the largest gap."""
CONDITION = [a for a in AXES if a != "engine"]


def write_figures(folder: Path) -> list[Path]:
    """Write box plots per joint and curves of the joints with the largest gaps. Returns the files.

    Box plots stand one above the other: the engines for every condition, and for every engine the revisions.

    Raises:
        InputError: where the folder holds no result table.
    """
    results = read_folder(folder)
    cells = results.cells.to_dict("records")
    written = []
    for condition, group in list(_by(cells, CONDITION).items())[:MOST]:
        name = _name(dict(zip(CONDITION, condition, strict=True)), results)
        contents = {str(c["engine"]): content for c in group if (content := _content(c, results))}
        sets = [_set(c, engine_label(str(c["engine"])), results) for c in group]
        written += _box_files(results, name, sets)
        if contents:
            failed = [s for s in sets if s.failed]
            written += _curve_files(results, name, contents, ", ".join(f"{s.label}: {s.failed}" for s in failed))
    if len(results.axes["robot_revision"]) > 1:
        others = [a for a in AXES if a != "robot_revision"]
        for condition, group in list(_by(cells, others).items())[:MOST]:
            name = _name(dict(zip(others, condition, strict=True)), results)
            if len(group) > 1:
                sets = [_set(c, str(c["robot_revision"]), results) for c in group]
                written += _box_files(results, f"revisions {name}", sets)
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


def _content(cell: dict[Any, Any], results: Results) -> dict[str, Any] | None:
    path = results.curves.get(cell_key(cell))
    return read_curves(path) if path else None


def _set(cell: dict[Any, Any], label: str, results: Results) -> BoxSet:
    content = _content(cell, results) or {}
    failed = "" if cell["outcome"] == "ok" else str(cell["outcome"])
    return BoxSet(label, engine_color(str(cell["engine"]), results.engines), content.get("boxes", {}), failed)


def _box_files(results: Results, name: str, sets: list[BoxSet]) -> list[Path]:
    out = []
    for signal in SIGNALS:
        units = sorted(results.gaps.loc[results.gaps["signal"] == signal, "unit"].unique())
        shown = " or ".join(unit_label(u) for u in units)
        out.append(draw_boxes(_path(results.folder, f"boxes {signal} {name}"), sets, signal, shown, name))
    return [path for path in out if path]


def _curve_files(results: Results, name: str, contents: dict[str, dict[str, Any]], failed: str) -> list[Path]:
    folder = results.folder
    simulated = next(iter(contents.values()))["simulated"]
    signal = next((s for s in SIGNALS if s in simulated), None)
    if signal is None:
        return []
    joints = list(simulated[signal])
    boxed = [c["boxes"][signal] for c in contents.values() if signal in c.get("boxes", {})]
    if boxed and all(j in boxed[0] for j in joints):
        joints = sorted(joints, key=lambda j: -max(b[j][3] for b in boxed if j in b))
    curves = []
    measured: dict[str, Any] = {}
    for engine, content in contents.items():
        if content.get("measured"):
            measured = read_curves(folder / "curves" / f"{content['measured']}.js").get(signal, {})
        color = engine_color(engine, results.engines)
        series = {j: unpack(content["simulated"][signal][j]) for j in joints[:CHOSEN]}
        curves.append(
            Curve(engine_label(engine), color, engine_dashes(engine, results.engines), unpack(content["time"]), series)
        )
    theirs = {j: unpack(measured[j]) for j in joints[:CHOSEN] if j in measured}
    title = f"{name} ({failed})" if failed else name
    units = {j: simulated[signal][j]["unit"] for j in joints[:CHOSEN]}
    return [draw_curves(_path(folder, f"curves {signal} {name}"), curves, theirs, units, signal, title)]


def _path(folder: Path, name: str) -> Path:
    safe = "".join(c if c.isalnum() or c in "-_." else "-" for c in name)
    return folder / "figures" / f"{safe}.svg"
