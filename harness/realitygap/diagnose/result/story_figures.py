"""The figures of a diagnosis as SVG inside its page: curves before and after, and gaps per run and per engine.

Colours: Okabe and Ito (2008), told apart by every eye. Ink and lines follow the page's light or dark scheme.
"""

from __future__ import annotations

import io
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.lib.stride_tricks import sliding_window_view

from realitygap.page.script import any_script
from realitygap.page.style import unit_label
from realitygap.robot.drive import Array

INK, MUTED, LINE, PAPER = "#1d2126", "#5c646d", "#dedad2", "#fdfcfb"
"""Stand for what the page's style sheet calls --ink, --muted, --line and --panel."""
BEFORE, AFTER = "#d55e00", "#0072b2"
STYLE: Any = {
    "font.size": 10,
    "axes.titlesize": 10,
    "axes.labelsize": 10,
    "text.color": INK,
    "axes.labelcolor": INK,
    "xtick.color": MUTED,
    "ytick.color": MUTED,
    "axes.edgecolor": LINE,
    "axes.grid": True,
    "axes.axisbelow": True,
    "text.parse_math": False,  # a name with $ in it is a name
    "grid.color": LINE,
    "grid.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "svg.fonttype": "none",  # text stays text: searchable, and small
    "svg.hashsalt": "realitygap",  # the same picture is the same text
    "figure.constrained_layout.use": True,
}
WIDE = 30.0
"""Residuals beyond this many floors are drawn on an axis that is logarithmic beyond 3."""
ABOVE = 2.0
"""Room above what is largest there, as a factor: a margin of the values' range is none on a logarithmic axis."""

CLOSE = (0.08, 0.04, 0.02, 0.01)
"""Of a run, how long a close-up is: the first in which the curves are seen to part, else the shortest."""
FEWEST = 10
"""Samples of a close-up at least."""
PARTED = 0.12
"""Curves are seen to part by so much of the picture's height."""
HALF = 0.5
"""Stretches in which curves part by this much of the largest difference part about as far."""
BAND = 40
"""More turns than this in the width of a picture are one dark band."""

DOT, RING = 6.0, 9.0
"""A gap after and before [pt]: the ring is seen around a dot at the same place."""

SEEN = 1.5
"""A root mean square difference below this many floors needs no close-up."""


@dataclass(frozen=True)
class Curves:
    """One joint and signal of one run, in people's units, on one clock [s]. Shapes (t,).

    `after` is None where nothing was added to the model; `sigma` is the floor; `spans` are the phases in which the gap
    is large [s].
    """

    time: Array
    measured: Array
    before: Array
    after: Array | None
    sigma: Array
    unit: str
    signal: str
    spans: Sequence[tuple[float, float]] = ()


@dataclass(frozen=True)
class Pair:
    """A row of a dot plot: a gap before and after; `after` is None where nothing was added."""

    label: str
    before: float
    after: float | None
    group: str = ""


def draw_curves(curves: Curves, title: str) -> str:
    """Measured and simulated together, close up where they hardly part, and the difference in floors. SVG."""
    close = _close_up(curves)
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(5.6, 3.7 if close is None else 5.3))
        axes = figure.subplots(2 if close is None else 3, 1, height_ratios=[5, 3] if close is None else [5, 4, 3])
        top, low = axes[0], axes[-1]
        low.sharex(top)
        for start, end in curves.spans:
            top.axvspan(start, end, color=LINE, alpha=0.55, linewidth=0)
        for panel in axes[:-1]:
            panel.plot(curves.time, curves.measured, color=INK, linewidth=2.6, alpha=0.5, label="measured")
            panel.plot(
                curves.time, curves.before, color=BEFORE, linewidth=1.3, linestyle=(0, (5, 2)), label=_before(curves)
            )
            if curves.after is not None:
                panel.plot(curves.time, curves.after, color=AFTER, linewidth=1.1, label="simulated after")
            panel.set_ylabel(f"{curves.signal} [{unit_label(curves.unit)}]")
        if close is not None:
            _zoom(axes[1], curves, close)
            axes[1].set_title("close up", loc="left")
        low.axhspan(-1, 1, color=MUTED, alpha=0.25, linewidth=0)
        low.plot(curves.time, _floors(curves, curves.before), color=BEFORE, linewidth=0.9)
        if curves.after is not None:
            low.plot(curves.time, _floors(curves, curves.after), color=AFTER, linewidth=0.9)
        low.set_ylabel("difference\n[floors]")
        for panel in axes:
            panel.set_xlabel("time [s]")
        _roomy(low)
        figure.align_ylabels(axes)
        figure.legend(*top.get_legend_handles_labels(), loc="outside upper left", ncols=3, frameon=False)
        return svg(figure, title)


def spans(time: Array, inside: Any) -> list[tuple[float, float]]:
    """The intervals [s] in which a mask holds. Both of shape (t,)."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], inside, [False]]).astype(int)))
    return [(float(time[a]), float(time[b - 1])) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def _close_up(curves: Curves) -> tuple[float, float] | None:
    """The stretch [s] in which the curves part most: before and after, or without an after, simulated and measured.

    It is as long as the difference is seen in it. Of stretches in which they part about as far, it is the one whose
    picture that fills most, as at a reversal. None where the curves are seen to part without: not where so many swings
    stand side by side that they are one dark band.
    """
    nothing = float(np.sqrt(np.nanmean(_floors(curves, curves.before) ** 2))) < SEEN
    apart = np.nan_to_num(np.abs(curves.before - curves.measured))
    seen = apart.max() > PARTED * float(np.ptp(curves.measured)) and _turns(curves) <= BAND
    if nothing or seen:
        return None
    if curves.after is not None:
        apart = np.nan_to_num(np.abs(curves.before - curves.after))
    size, start = len(apart), 0
    for share in CLOSE:
        size = min(max(round(share * len(apart)), FEWEST), len(apart))
        parts = sliding_window_view(apart, size).mean(axis=-1)
        reach = np.ptp(sliding_window_view(np.nan_to_num(curves.measured), size), axis=-1)
        filled = np.where(parts >= HALF * parts.max(), parts / np.maximum(reach + parts, 1e-300), 0.0)
        start = int(np.argmax(filled))
        if filled[start] > HALF * PARTED:
            break
    return float(curves.time[start]), float(curves.time[start + size - 1])


def _turns(curves: Curves) -> int:
    """How often what was measured swings through its middle half, where that is seen in the picture."""
    low, high = np.nanquantile(curves.measured, (0.25, 0.75))
    both = np.concatenate([curves.measured, curves.before])
    if high - low < PARTED * float(np.nanmax(both) - np.nanmin(both)):
        return 0
    sides = (curves.measured >= high).astype(int) - (curves.measured <= low)
    return int(np.count_nonzero(np.diff(sides[sides != 0])))


def _zoom(axes: Axes, curves: Curves, window: tuple[float, float]) -> None:
    axes.set_xlim(*window)
    inside = (curves.time >= window[0]) & (curves.time <= window[1])
    shown = [c[inside] for c in (curves.measured, curves.before, curves.after) if c is not None]
    low, high = float(np.nanmin(shown)), float(np.nanmax(shown))
    axes.set_ylim(low - 0.1 * (high - low), high + 0.1 * (high - low))


def draw_pairs(pairs: Sequence[Pair], title: str) -> str:
    """A dot plot of gaps before (hollow) and after (filled), in floors; the floor is a line at 1. SVG."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(5.6, 0.75 + 0.24 * (len(pairs) + len({p.group for p in pairs if p.group}))))
        axes = figure.subplots()
        _dots(axes, pairs)
        axes.set_xlabel("gap [floors]")
        axes.grid(visible=False, axis="y")
        axes.spines["left"].set_visible(False)
        axes.tick_params(axis="y", length=0)
        return svg(figure, title)


def _dots(axes: Axes, pairs: Sequence[Pair]) -> None:
    axes.axvline(1.0, color=MUTED, linewidth=1.2, linestyle=(0, (2, 2)))
    y, ticks, labels, group = 0.0, [], [], ""
    groups = {p.group for p in pairs if p.group}
    for pair in pairs:
        if pair.group != group:
            group = pair.group
            ticks.append(y)
            labels.append(group)
            y -= 1.0
        ticks.append(y)
        labels.append(pair.label)
        if pair.after is not None:
            axes.plot([pair.before, pair.after], [y, y], color=MUTED, linewidth=1.2, zorder=1)
            axes.plot(pair.after, y, "o", color=AFTER, markersize=DOT, zorder=3)
        axes.plot(
            pair.before, y, "o", color=BEFORE, markerfacecolor=PAPER, markeredgewidth=1.6, markersize=RING, zorder=2
        )
        y -= 1.0
    axes.set_yticks(ticks, labels)
    for label in axes.get_yticklabels():
        label.set_color(MUTED if label.get_text() in groups else INK)
    axes.set_ylim(y + 0.4, 0.6)
    values = [v for p in pairs for v in (p.before, p.after) if v is not None]
    if max(values) > 8:
        axes.set_xscale("log")
        axes.set_xlim(min(0.7, 0.8 * min(values)), 1.3 * max(values))
        powers = [t for t in (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000) if t < 1.3 * max(values)]
        axes.set_xticks(powers[:: 1 + len(powers) // 9], [f"{t:g}" for t in powers[:: 1 + len(powers) // 9]])
        axes.set_xticks([], minor=True)
    else:
        axes.set_xlim(0, 1.1 * max(*values, 1.0))


def _before(curves: Curves) -> str:
    return "simulated" if curves.after is None else "simulated before"


def _floors(curves: Curves, simulated: Array) -> Array:
    return np.asarray((simulated - curves.measured) / curves.sigma)


def _roomy(axes: Axes) -> None:
    """An axis around zero, logarithmic beyond 3 where the values are very large."""
    reach = max(abs(v) for v in axes.get_ylim())
    if reach > WIDE:
        axes.set_yscale("symlog", linthresh=3)
        powers = [10.0**k for k in range(1, 7) if 10.0**k < reach]
        ticks = [-t for t in reversed(powers)] + [0.0, *powers]
        named = (-powers[-1], 0.0, powers[-1])  # the others between them have no room for a name
        axes.set_yticks(ticks, [f"{t:g}".replace("-", "−") if t in named else "" for t in ticks])
        axes.set_yticks([], minor=True)
        reach *= ABOVE
    axes.set_ylim(-reach, reach)


def svg(figure: Figure, title: str) -> str:
    """The figure as an element of the page, with the page's own colours."""
    out = io.StringIO()
    with any_script():
        figure.savefig(out, format="svg", transparent=True, metadata={"Date": None, "Creator": None})
    text = out.getvalue()
    text = text[text.index("<svg") :]
    text = re.sub(r"<metadata>.*?</metadata>", "", text, flags=re.DOTALL)
    text = re.sub(r' id="[a-z0-9]+_\d+"', "", text)  # names of groups, which stand in every figure
    text = re.sub(r' d="[^"]*"', _shorter, text)
    for color, name in _NAMES.items():
        text = text.replace(color, f"var(--{name})")
    label = title.replace("&", "&amp;").replace("<", "&lt;").replace('"', "&quot;")
    text = re.sub(r'width="[\d.]+pt" height="[\d.]+pt"', "", text, count=1)
    text = re.sub(r"font: ([\d.]+)px [^;\"]*", r"font-size: \1px; font-family: var(--sans)", text)
    return text.replace("<svg", f'<svg class="figure" role="img" aria-label="{label}"', 1)


_NAMES: Mapping[str, str] = {INK: "ink", MUTED: "muted", LINE: "line", PAPER: "panel", BEFORE: "before", AFTER: "after"}


def _shorter(match: re.Match[str]) -> str:
    """A path with a hundredth of a point: a tenth of what a screen shows."""
    return re.sub(r"\d+\.\d+", lambda m: f"{float(m[0]):.2f}".rstrip("0").rstrip("."), match[0])
