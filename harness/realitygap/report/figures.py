"""The figures of a result folder, as files for papers and slides: `figures/*.svg`, made from table and traces alone."""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from realitygap.compare.gap import BASE
from realitygap.compare.row import file_name
from realitygap.compare.traces import CellTraces, read_traces
from realitygap.files.errors import spared
from realitygap.page.style import AXES, SIGNALS, axis_value, engine_color, engine_dashes, engine_label, unit_label
from realitygap.report.curves import boxes, series, thinned
from realitygap.report.each import Each, one_by_one
from realitygap.report.folder import Results, cell_key, read_folder
from realitygap.trace.trace import Array, Trace

if TYPE_CHECKING:
    from realitygap.report.draw import BoxSet

MOST = 6
"""Conditions that get figures of their own; a larger matrix has its page."""
CHOSEN = 4
"""Joints whose curves are drawn: those with the largest gap."""
SAMPLES = 500
"""Samples of a curve: as many as a panel has pixels."""
CONDITION = [a for a in AXES if a != "engine"]


@dataclass(frozen=True)
class Shown:
    """An engine or a revision in one figure, and the file of its traces; None where nothing was simulated."""

    label: str
    color: str
    dashes: int
    failed: str
    path: Path | None


@dataclass(frozen=True)
class Drawing:
    """One figure that is to be drawn, from files alone.

    Attributes:
        out: the folder that takes it.
        name: what tells its condition from the others, in words.
        shown: engines or revisions, one above the other or together.
        signal: whose box plots it shows; None for curves, of the first signal there is.
        units: of the box plots, in words.
    """

    out: Path
    name: str
    shown: tuple[Shown, ...]
    signal: str | None = None
    units: str = ""


def write_figures(
    folder: Path, out: Path | None = None, failures: list[str] | None = None, each: Each = one_by_one
) -> list[Path]:
    """Write box plots per joint and curves of the joints with the largest gaps. Returns the files.

    Box plots stand one above the other: the engines for every condition, and for every engine the revisions.

    Args:
        folder: the result folder.
        out: where to write (default: there).
        failures: takes sentences on figures that could not be drawn.
        each: does work for every item, in other processes where there are some.

    Raises:
        InputError: where the folder holds no result table, or a file of it is damaged.
    """
    found = each(drawn, drawings(read_folder(folder), out or folder))
    if failures is not None:
        failures += dict.fromkeys(sentence for _, said in found for sentence in said)
    return [path for path, _ in found if path]


def drawings(results: Results, out: Path) -> list[Drawing]:
    """The figures of a result folder; those of signals that a condition does not have come to nothing."""
    cells = results.cells.to_dict("records")
    units = {s: sorted(results.gaps.loc[results.gaps["signal"] == s, "unit"].unique()) for s in SIGNALS}
    words = {s: " or ".join(unit_label(u) for u in found) for s, found in units.items()}
    todo: list[Drawing] = []

    def boxed(name: str, shown: tuple[Shown, ...]) -> None:
        todo.extend(Drawing(out, name, shown, s, words[s]) for s in SIGNALS)

    for condition, group in list(_by(cells, CONDITION).items())[:MOST]:
        name = _name(dict(zip(CONDITION, condition, strict=True)), results)
        shown = tuple(_shown(c, engine_label(str(c["engine"])), results) for c in group)
        boxed(name, shown)
        todo.append(Drawing(out, name, shown))
    if len(results.axes["robot_revision"]) > 1:
        others = [a for a in AXES if a != "robot_revision"]
        for condition, group in list(_by(cells, others).items())[:MOST]:
            name = _name(dict(zip(others, condition, strict=True)), results)
            if len(group) > 1:
                shown = tuple(_shown(c, str(c["robot_revision"]), results) for c in group)
                boxed(f"revisions {name}", shown)
    return todo


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


def _shown(cell: dict[Any, Any], label: str, results: Results) -> Shown:
    failed = "" if cell["outcome"] == "ok" else str(cell["outcome"])
    engine, path = str(cell["engine"]), results.traces.get(cell_key(cell))
    return Shown(label, engine_color(engine, results.engines), engine_dashes(engine, results.engines), failed, path)


def drawn(one: Drawing) -> tuple[Path | None, list[str]]:
    """Draw a figure: its file, None where there is nothing to draw, and a sentence where it could not be drawn.

    Raises:
        InputError: where a file of traces is damaged.
    """
    from realitygap.report.draw import BoxSet, draw_boxes  # matplotlib, which who only hands out drawings does not need

    signals = Trace.SIGNALS if one.signal is None else _columns(one.signal)
    traces = {s.label: read_traces(s.path, signals) for s in one.shown if s.path}
    failures: list[str] = []
    with spared(f"figures of {one.name}", failures):
        sets = [BoxSet(s.label, s.color, boxes(traces[s.label]) if s.path else {}, s.failed) for s in one.shown]
        if one.signal is None:
            return (_curves(one, traces, sets) if traces else None), failures
        return draw_boxes(_path(one.out, f"boxes {one.signal} {one.name}"), sets, one.signal, one.units, one.name), []
    return None, failures


def _columns(signal: str) -> tuple[str, ...]:
    """What has to be read of traces for the box plots of a signal."""
    base = next((name for name, (told, _, _) in BASE.items() if told == signal), None)
    return (signal,) if base is None else (base, base.replace("base_", "imu_"))


def _curves(one: Drawing, traces: dict[str, CellTraces], sets: Sequence["BoxSet"]) -> Path | None:
    """The curves of the joints with the largest gaps, measured and in every engine, in the first signal there is."""
    from realitygap.report.draw import Curve, draw_curves

    first = next(iter(traces.values()))
    named = series(first.simulated, first)
    signal = next((s for s in SIGNALS if named.get(s)), None)  # a free body has positions of no joints
    if signal is None:
        return None
    joints = list(named[signal])
    boxed = [s.boxes[signal] for s in sets if signal in s.boxes]
    if boxed and all(j in boxed[0] for j in joints):
        joints = sorted(joints, key=lambda j: -max(b[j][3] for b in boxed if j in b))
    joints = joints[:CHOSEN]
    curves = []
    measured: dict[str, Array] = {}
    for shown in one.shown:
        if shown.label not in traces:
            continue
        cell = traces[shown.label]
        clock = thinned(cell, SAMPLES)
        ours = series(cell.simulated.at(clock), cell)[signal]
        if cell.measured is not None:
            theirs = series(cell.measured.at(clock), cell).get(signal, {})
            measured = {j: theirs[j][1] for j in joints if j in theirs}
        values = {j: ours[j][1] for j in joints}
        curves.append(Curve(shown.label, shown.color, shown.dashes, clock - clock[0], values))
    failed = ", ".join(f"{s.label}: {s.failed}" for s in sets if s.failed)
    units = {j: named[signal][j][0] for j in joints}
    title = f"{one.name} ({failed})" if failed else one.name
    return draw_curves(_path(one.out, f"curves {signal} {one.name}"), curves, measured, units, signal, title)


def _path(folder: Path, name: str) -> Path:
    return folder / "figures" / f"{file_name(name)}.svg"
