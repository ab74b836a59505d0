"""Drawing with matplotlib: box plots per joint, one set above the other, and curves with the difference below."""

import io
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from harness.drive import Array
from harness.report.style import SIGNALS, unit_label
from harness.results import write_whole

STYLE: Any = {
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": "#8a8a8a",
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#e4e2dd",
    "grid.linewidth": 0.7,
    "svg.fonttype": "none",  # text stays text: searchable, and small
    "svg.hashsalt": "realitygap",  # the same picture is the same file
    "figure.constrained_layout.use": True,
}
DASHES = ("-", (0, (6, 2)), (0, (2, 1.5)), (0, (6, 1.5, 1.5, 1.5)), (0, (3, 3)))
INK = "#1d2126"


@dataclass(frozen=True)
class BoxSet:
    """The box statistics of one engine or revision: signal -> joint -> six numbers, as in the curve files."""

    label: str
    color: str
    boxes: dict[str, dict[str, list[float]]]
    series: dict[str, dict[str, Any]]


@dataclass(frozen=True)
class Curve:
    """One engine's simulated series per joint, in people's units, over `time` [s]. Shapes (t,)."""

    label: str
    color: str
    dashes: int
    time: Array
    joints: dict[str, Array]


def draw_boxes(path: Path, sets: list[BoxSet], signal: str, title: str) -> Path | None:
    """Box plots of the absolute difference per joint; one panel per set, on one scale. None without any joint."""
    joints = list(dict.fromkeys(j for s in sets for j in s.boxes.get(signal, {})))
    units = {s.series.get(signal, {}).get(j, {}).get("unit", "") for s in sets for j in joints}
    if not joints:
        return None
    unit = unit_label(" or ".join(sorted(units - {""})) or "m")
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(max(4.5, 1.6 + 0.42 * len(joints)), 1.1 + 1.7 * len(sets)))
        panels = figure.subplots(len(sets), 1, sharex=True, sharey=True, squeeze=False)[:, 0]
        for axes, one in zip(panels, sets, strict=True):
            _boxes(axes, one, signal, joints)
            axes.set_ylabel(f"{one.label}\n[{unit}]")
            axes.set_ylim(bottom=0)
        panels[-1].set_xticks(range(len(joints)), joints, rotation=0 if len(joints) < 4 else 60, ha="center")
        if len(joints) >= 4:
            for tick in panels[-1].get_xticklabels():
                tick.set_ha("right")
                tick.set_rotation_mode("anchor")
        figure.suptitle(f"{SIGNALS[signal].capitalize()}: |simulated − measured|, {title}", fontsize=10)
        return _save(figure, path)


def _boxes(axes: Axes, one: BoxSet, signal: str, joints: list[str]) -> None:
    stats, places = [], []
    for place, joint in enumerate(joints):
        numbers = one.boxes.get(signal, {}).get(joint)
        if numbers is None:
            axes.annotate("none", (place, 0), ha="center", va="bottom", color="#8a8a8a", fontsize=8)
            continue
        low, q1, median, q3, high, most = numbers
        stats.append({"whislo": low, "q1": q1, "med": median, "q3": q3, "whishi": high, "fliers": [most]})
        places.append(place)
    axes.bxp(
        stats,
        positions=places,
        widths=0.6,
        patch_artist=True,
        manage_ticks=False,
        boxprops={"facecolor": one.color, "alpha": 0.45, "edgecolor": one.color},
        medianprops={"color": INK, "linewidth": 1.6},
        whiskerprops={"color": one.color},
        capprops={"color": one.color},
        flierprops={"marker": "o", "markersize": 3, "markerfacecolor": "none", "markeredgecolor": one.color},
    )
    axes.set_xlim(-0.6, len(joints) - 0.4)


def draw_curves(
    path: Path, curves: list[Curve], measured: dict[str, Array], units: dict[str, str], signal: str, title: str
) -> Path:
    """Curves of some joints: measured and every engine's simulated together, and the difference below."""
    joints = list(units)
    rows = 2 if measured else 1
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(max(5.5, 3.4 * len(joints)), 2.6 + 1.7 * (rows - 1)))
        grid = figure.subplots(rows, len(joints), sharex=True, squeeze=False, height_ratios=[2, 1][:rows])
        for column, joint in enumerate(joints):
            top = grid[0, column]
            if joint in measured:
                top.plot(curves[0].time, measured[joint], color=INK, linewidth=1.8, label="measured")
            for curve in curves:
                style: dict[str, Any] = {"color": curve.color, "linestyle": DASHES[curve.dashes], "linewidth": 1.2}
                top.plot(curve.time, curve.joints[joint], label=curve.label, **style)
                if joint in measured:
                    grid[1, column].plot(curve.time, curve.joints[joint] - measured[joint], **style)
            top.set_title(joint, fontsize=9)
            top.set_ylabel(f"{SIGNALS[signal]} [{unit_label(units[joint])}]")
            if rows == 2:
                grid[1, column].set_ylabel(f"difference [{unit_label(units[joint])}]")
            grid[-1, column].set_xlabel("time [s]")
        handles, labels = grid[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=min(len(labels), 6), frameon=False)
        figure.suptitle(f"{SIGNALS[signal].capitalize()}, {title}", fontsize=10)
        return _save(figure, path)


def _save(figure: Figure, path: Path) -> Path:
    out = io.BytesIO()
    figure.savefig(out, format=path.suffix[1:], metadata={"Date": None})
    write_whole(path, out.getvalue())
    return path
