"""Drawing with matplotlib: box plots per joint, one set above the other, and curves with the difference below."""

import io
from dataclasses import dataclass
from pathlib import Path
from textwrap import fill
from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure

from realitygap.files.whole import write_whole
from realitygap.page.script import any_script
from realitygap.page.style import SIGNALS, unit_label
from realitygap.trace.trace import Array

STYLE: Any = {
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": "#8a8a8a",
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#e4e2dd",
    "grid.linewidth": 0.7,
    "text.parse_math": False,  # a name with $ in it is a name
    "svg.fonttype": "none",  # text stays text: searchable, and small
    "svg.hashsalt": "realitygap",  # the same picture is the same file
    "figure.constrained_layout.use": True,
}
DASHES = (
    "-",
    (0, (6, 2)),
    (0, (2, 1.5)),
    (0, (6, 1.5, 1.5, 1.5)),
    (0, (3, 3)),
    (0, (9, 2)),
    (0, (6, 1.5, 1.5, 1.5, 1.5, 1.5)),
)
INK = "#1d2126"
INCH = 72.0
"""Points in an inch."""
WIDE = 0.7
"""How wide a letter is, at most, in the mean of a bold line, of its size: 0.69 in names and numbers."""


@dataclass(frozen=True)
class BoxSet:
    """The box statistics of one engine or revision: signal -> joint -> six numbers.

    `failed` is the outcome in a word where the simulation did not finish.
    """

    label: str
    color: str
    boxes: dict[str, dict[str, list[float]]]
    failed: str = ""


@dataclass(frozen=True)
class Curve:
    """One engine's simulated series per joint, in people's units, over `time` [s]. Shapes (t,)."""

    label: str
    color: str
    dashes: int
    time: Array
    joints: dict[str, Array]


def draw_boxes(path: Path, sets: list[BoxSet], signal: str, units: str, title: str) -> Path | None:
    """Box plots of the absolute difference per joint; one panel per set, on one scale. None without any joint.

    A single joint needs no panels: its sets stand side by side.
    """
    joints = list(dict.fromkeys(j for s in sets for j in s.boxes.get(signal, {})))
    if not joints:
        return None
    single = len(joints) == 1
    rows = 1 if single else len(sets)
    names = [s.label for s in sets] if single else joints
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(max(5.0, 1.6 + 0.42 * len(names)), 1.3 + 1.7 * max(rows, 1.3)))
        panels = figure.subplots(rows, 1, sharex=True, sharey=True, squeeze=False)[:, 0]
        for row, one in enumerate(sets):
            axes = panels[0] if single else panels[row]
            _boxes(axes, one, signal, joints, row if single else 0)
            beside = in_lines(f"{joints[0]} [{units}]", figure.get_figheight() / rows, STYLE["font.size"])
            axes.set_ylabel(beside if single else f"{one.label}\n[{units}]")
            axes.set_ylim(bottom=0)
            axes.set_xlim(-0.6, len(names) - 0.4)
        tilt = len(names) > 6
        style: dict[str, Any] = {"rotation": 60, "ha": "right", "rotation_mode": "anchor"} if tilt else {}
        panels[-1].set_xticks(range(len(names)), names, **style)
        head(figure, f"{SIGNALS[signal].capitalize()}: |simulated − measured|, {title}", fontsize=10)
        return save(figure, path)


def _boxes(axes: Axes, one: BoxSet, signal: str, joints: list[str], first: int) -> None:
    if one.failed:
        middle = first if len(joints) == 1 else (len(joints) - 1) / 2
        axes.annotate(one.failed, (middle, 0.5), xycoords=("data", "axes fraction"), ha="center", color=one.color)
        return
    stats, places = [], []
    for place, joint in enumerate(joints, start=first):
        numbers = one.boxes.get(signal, {}).get(joint)
        if numbers is None:
            axes.annotate(
                "not measured", (place, 0), ha="center", va="bottom", color="#6a6a6a", fontsize=7, rotation=90
            )
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
            top.set_title(in_lines(joint, figure.get_figwidth() / len(joints), 9.0), fontsize=9)
            top.set_ylabel(f"{SIGNALS[signal]} [{unit_label(units[joint])}]")
            if rows == 2:
                grid[1, column].set_ylabel(f"difference [{unit_label(units[joint])}]")
            grid[-1, column].set_xlabel("time [s]")
        handles, labels = grid[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=min(len(labels), 6), frameon=False)
        head(figure, f"{SIGNALS[signal].capitalize()}, {title}", fontsize=10)
        return save(figure, path)


def head(figure: Figure | SubFigure, text: str, fontsize: float, **style: Any) -> None:
    """Write a title above a figure, in as many lines as it takes."""
    width = figure.bbox.width / figure.get_figure(root=True).dpi
    figure.suptitle(in_lines(text, width, fontsize), fontsize=fontsize, **style)


def in_lines(text: str, width: float, fontsize: float) -> str:
    """Text in lines that are no wider than this [in], of letters that are `WIDE`; a word that is goes over several."""
    return fill(text, max(int(INCH * width / (WIDE * fontsize)), 1), break_on_hyphens=False)


def save(figure: Figure, path: Path) -> Path:
    """Write a figure whole; the same picture is the same file."""
    out = io.BytesIO()
    with any_script():
        figure.savefig(out, format=path.suffix[1:], metadata={"Date": None})
    write_whole(path, out.getvalue())
    return path
