"""The picture of a missing effort: over time beside the motion, and against all that it may depend on.

Motion forward and backward have colours of their own, because what a mechanic looks for tells itself that way: friction
is two bands on either side of zero, a cable or a spring a slope, teeth and magnets a wave over the angle, a gear that
rubs under load a fan, play and give a bend after each reversal.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from realitygap.missing.effort import BAND, MissingEffort
from realitygap.missing.words import depends
from realitygap.page.style import quantity
from realitygap.report.draw import INK, STYLE, head, save
from realitygap.robot.law.effort_map import TURNING
from realitygap.trace.trace import Array

FORWARD, BACKWARD, RESTING = "#0072b2", "#d55e00", "#9a9a9a"
AXES = {
    "angle": ("angle", ("°", "mm"), (180 / np.pi, 1e3)),
    "speed": ("speed", ("°/s", "mm/s"), (180 / np.pi, 1e3)),
    "load": ("load: gravity and inertia", ("N·m", "N"), (1.0, 1.0)),
    "error": ("command − position", ("°", "mm"), (180 / np.pi, 1e3)),
    "reversal": ("time since the last reversal", ("s", "s"), (1.0, 1.0)),
    "supply": ("supply", ("V", "V"), (1.0, 1.0)),
    "temperature": ("temperature", ("°C", "°C"), (1.0, 1.0)),
}
"""Of every variable: what it is called, its units for hinges and slides, and what SI is multiplied by."""
LONGEST = 12.0
"""What is drawn over time at most [s]: the part with the most motion."""
OVER_TIME, POINTS, BINS = 800, 350, 24
COLUMNS = 5


def draw_missing(path: Path, runs: Sequence[MissingEffort], told: dict[str, Any]) -> Path:
    """Draw the missing effort of one joint over these recordings; `told` is what it depends on, as in the JSON file."""
    joint, unit = told["joint"], told["unit"]
    j = runs[0].joints.index(joint)
    variables = [v for v in AXES if all(v in r.variables and np.ptp(r.variables[v][:, j]) > 0 for r in runs)]
    rows = 1 if len(variables) <= COLUMNS else 2
    columns = -(-len(variables) // rows)
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(11.0, 4.0 + 2.6 * rows), dpi=150)
        upper, lower = np.ravel(figure.subfigures(2, 1, height_ratios=[4.0, 2.6 * rows], squeeze=False))
        _over_time(upper, _most_moved(runs, j), j, joint, unit)
        panels = lower.subplots(rows, columns, sharey=True, squeeze=False)
        for axes, variable in zip(panels.flat, variables, strict=False):
            _against(axes, variable, runs, j, told)
        for axes in panels.flat[len(variables) :]:
            axes.set_visible(False)
        named: dict[str, Any] = {}  # every curve once
        for axes in panels.flat:
            named |= {label: handle for handle, label in zip(*axes.get_legend_handles_labels(), strict=True)}
        if named:
            lower.legend(named.values(), named, loc="outside lower center", ncols=3, frameon=False, fontsize=8)
        for axes in panels[:, 0]:
            axes.set_ylabel(f"missing effort [{unit}]")
        seen = np.concatenate([r.effort[:, j] for r in runs])
        low, high = np.quantile(seen, [0.002, 0.998])
        room = 0.12 * (high - low) + 1e-12
        panels[0, 0].set_ylim(min(low, 0) - room, max(high, 0) + room)
        return save(figure, path)


def _most_moved(runs: Sequence[MissingEffort], j: int) -> MissingEffort:
    return max(runs, key=lambda r: float(np.mean(np.abs(r.variables["speed"][:, j]))))


def _over_time(figure: Any, run: MissingEffort, j: int, joint: str, unit: str) -> None:
    top, bottom = figure.subplots(2, 1, sharex=True, height_ratios=[1, 1.4])
    chosen = _part(run, j)
    time = run.time[chosen] - run.time[0]
    _, units, scales = AXES["angle"]
    slide = run.slides[j]
    angle = run.variables["angle"][chosen, j] * scales[slide]
    if "error" in run.variables:
        command = angle + run.variables["error"][chosen, j] * scales[slide]
        top.plot(time, command, color=RESTING, linewidth=1.0, label="command", drawstyle="steps-post")
    top.plot(time, angle, color=INK, linewidth=1.4, label="measured")
    top.set_ylabel(f"position [{units[slide]}]")
    effort, error = run.effort[chosen, j], BAND * run.error[chosen, j]
    colors = _direction(run.variables["speed"][chosen, j])
    bottom.axhline(0, color=INK, linewidth=0.8)
    bottom.fill_between(
        time, effort - error, effort + error, color="#e69f00", alpha=0.35, linewidth=0, label="95 % band"
    )
    for color, name in ((FORWARD, "moving forward"), (BACKWARD, "moving backward"), (RESTING, "")):
        shown = np.where(colors == color, effort, np.nan)
        bottom.plot(time, shown, color=color if name else INK, linewidth=1.5, label=name or "at rest")
    reach = 1.25 * float(np.quantile(np.abs(effort) + 0.5 * error, 0.995)) + 1e-12
    bottom.set_ylim(-reach, reach)
    bottom.set_ylabel(f"missing effort [{unit}]")
    bottom.set_xlabel("time [s]")
    for axes in (top, bottom):
        axes.legend(loc="lower right", bbox_to_anchor=(1.0, 0.97), ncols=4, frameon=False, fontsize=8)
    size, load = (np.sqrt(np.mean(v[:, j] ** 2)) for v in (run.effort, run.variables["load"]))
    text = f"{quantity(size, unit, 2)} rms, where gravity and inertia ask for {quantity(load, unit, 2)}"
    bottom.set_title(text, loc="left", fontsize=9)
    head(figure, f"{joint}: what the model lacks to follow {run.name}", fontsize=11, fontweight="bold")


def _part(run: MissingEffort, j: int) -> Array:
    """The samples of the stretch with the most motion, thinned. Indices."""
    step = float(np.median(np.diff(run.time)))
    width = min(max(int(LONGEST / step), 2), len(run.time))
    way = np.concatenate([[0.0], np.cumsum(np.abs(run.variables["speed"][:, j]))])
    begin = int(np.argmax(way[width:] - way[:-width]))
    return np.asarray(np.arange(begin, begin + width, max(1, width // OVER_TIME)))


def _direction(speed: Array) -> Any:
    return np.where(speed > TURNING, FORWARD, np.where(speed < -TURNING, BACKWARD, RESTING))


def _against(axes: Axes, variable: str, runs: Sequence[MissingEffort], j: int, told: dict[str, Any]) -> None:
    name, units, scales = AXES[variable]
    slide = runs[0].slides[j]
    x = np.concatenate([r.variables[variable][:, j] for r in runs])
    effort = np.concatenate([r.effort[:, j] for r in runs])
    colors = _direction(np.concatenate([r.variables["speed"][:, j] for r in runs]))
    axes.axhline(0, color=INK, linewidth=0.8)
    order = np.random.default_rng(0).permutation(len(x))
    for color in (RESTING, FORWARD, BACKWARD):
        own = order[colors[order] == color]
        shown = own[:POINTS]
        axes.plot(x[shown] * scales[slide], effort[shown], ".", color=color, markersize=2.4, alpha=0.5, rasterized=True)
        if color != RESTING and len(own) > 5 * BINS:
            middle, median = _medians(x[own], effort[own])
            way = "forward" if color == FORWARD else "backward"
            axes.plot(middle * scales[slide], median, color=color, linewidth=1.8, label=f"median, moving {way}")
    low, high = np.quantile(x, [0.002, 0.998]) * scales[slide]
    axes.set_xlim(low - 0.04 * (high - low), high + 0.04 * (high - low))
    axes.set_xlabel(f"{name} [{units[slide]}]")
    terms = [t for t in told["terms"] if variable in t["variables"]]
    for term in terms:
        if len(term["variables"]) == 1:
            knots, fitted = np.array(term["knots"][0]) * scales[slide], f"fitted function of {depends(term)}"
            axes.plot(knots, term["values"], color=INK, linewidth=2.0, zorder=3, label=fitted)
        together = "together " if len(term["variables"]) > 1 else ""
        axes.set_title(f"{together}explains {100 * term['share']:.0f} %", fontsize=9, fontweight="bold")
        axes.set_facecolor("#fff8e5")


def _medians(x: Array, y: Array) -> tuple[Array, Array]:
    """Medians over bins with as many samples each."""
    parts = np.array_split(np.argsort(x), BINS)
    return np.array([np.median(x[p]) for p in parts]), np.array([np.median(y[p]) for p in parts])
