"""`realitygap effects`: the table of effects, and the page of one with a plot of its signature."""

import textwrap
from pathlib import Path

import numpy as np

from realitygap.robot.effects import WRITABLE, Effect, Parameter
from realitygap.robot.effects.place import known
from realitygap.simulate.effect_bench import bench, motion, planted, signal, simulate
from realitygap.trace.trace import Array

WIDTH = 88
"""Columns of a page."""
DOTS = ((0x01, 0x08), (0x02, 0x10), (0x04, 0x20), (0x40, 0x80))
"""The bits of a braille character, by row and column (Unicode, block U+2800)."""


def table() -> str:
    """All effects, in the order in which the simpler of two explanations is preferred."""
    rows = [("effect", "sits at", "changes", "parameters")]
    for e in WRITABLE.values():
        listed = ", ".join(p.with_unit for p in e.parameters) or ", ".join(e.example)
        rows.append((e.name, e.sits_at, e.changes, listed))
    widths = [max(len(row[i]) for row in rows) for i in range(3)]
    lines = ["  ".join((*(cell.ljust(w) for cell, w in zip(row, widths, strict=False)), row[3])) for row in rows]
    return "\n".join([*lines, "", "realitygap effects NAME tells more of one."])


def page(name: str) -> str:
    """What there is to know about one effect, with a plot of what it does to a bench, simulated now.

    Raises:
        InputError: for an unknown effect.
    """
    effect = known(name)
    p = effect.page
    plant, index = bench(effect)
    size = effect.first_size(plant, index)
    where = f"{'a' if effect.sits_at in ('joint', 'link') else 'the'} {effect.sits_at}"
    blocks = [
        effect.name,
        f"changes the {effect.changes}, sits at {where}; shows in {', '.join(effect.signals)}",
        _wrapped(p.physics),
        textwrap.fill(p.equation, WIDTH, initial_indent="    ", subsequent_indent="    ", break_on_hyphens=False),
        *(["\n".join(_parameter(x) for x in effect.parameters)] if effect.parameters else []),
        _wrapped("In a recording: " + p.signature),
        _wrapped("Easily confused with: " + p.confused_with),
        *([f"Excludes on the same target: {', '.join(effect.excludes)}"] if effect.excludes else []),
        _wrapped("Source: " + p.source),
        _wrapped(f"In a scenario: {_example(effect, size)}", "    "),
        _plot(effect),
    ]
    return "\n\n".join(blocks)


def signature(effect: Effect) -> tuple[str, str, Array, Array, Array]:
    """The bench without and with the effect: signal, unit, times [s] and both curves. Shape (t,)."""
    plant, _ = bench(effect)
    before = simulate(plant, what=motion(effect))
    what, unit, without = signal(effect, before)
    return what, unit, before.time, without, signal(effect, simulate(planted(effect), what=motion(effect)))[2]


def save_figure(name: str, path: Path) -> None:
    """Write the signature of an effect as a figure, by suffix. Raises InputError for an unknown effect."""
    from matplotlib.figure import Figure

    effect = known(name)
    what, unit, time, without, with_effect = signature(effect)
    figure = Figure(figsize=(7, 4.5), layout="constrained")
    top, bottom = figure.subplots(2, 1, sharex=True)
    top.plot(time, without, color="0.6", label="without")
    top.plot(time, with_effect, label=f"with {name}")
    top.set_ylabel(f"{what} [{unit}]")
    top.legend(frameon=False)
    bottom.plot(time, with_effect - without)
    bottom.set(xlabel="time [s]", ylabel=f"difference [{unit}]")
    figure.savefig(path, dpi=150)


def _parameter(p: Parameter) -> str:
    neutral = "the model's own" if p.absent is None else f"{p.absent:g}"
    default = "" if p.default is None else f", {p.default:g} where left out"
    return f"    {p.name.ljust(18)} {p.unit.ljust(20)} {p.low:g} to {p.high:g}; neutral: {neutral}{default}"


def _written(value: object) -> str:
    if isinstance(value, list | tuple):
        return f"[{', '.join(_written(v) for v in value)}]"
    return f"{value:.3g}" if isinstance(value, float) else str(value)


def _example(effect: Effect, size: dict[str, float]) -> str:
    target = {"joint": "left_knee", "link": "left_shank"}.get(effect.sits_at, effect.sits_at)
    given = ", ".join(f"{name}: {_written(value)}" for name, value in size.items())
    return f"{{effect: {effect.name}, target: {target}, {given}}}"


def _wrapped(text: str, indent: str = "") -> str:
    return textwrap.fill(text, WIDTH, subsequent_indent=indent, break_on_hyphens=False)


def _plot(effect: Effect) -> str:
    what, unit, time, without, with_effect = signature(effect)
    place = "a block on the ground" if effect.sits_at == "ground" else "a servo that swings an arm"
    title = f"{what} with minus without, on {place} [{unit}]:"
    return title + "\n" + braille(time, with_effect - without)


def braille(x: Array, y: Array, columns: int = 72, rows: int = 8) -> str:
    """A line plot in braille characters, with the range of y at its left and of x below. Zero is drawn dotted."""
    low, high = min(float(y.min()), 0.0), max(float(y.max()), 0.0)
    span = high - low or 1.0
    cells = np.zeros((rows, columns), dtype=int)

    def dot(column: int, value: float) -> int:
        row = round((high - value) / span * (4 * rows - 1))
        cells[row // 4, column // 2] |= DOTS[row % 4][column % 2]
        return row

    grid = np.linspace(x[0], x[-1], 2 * columns)
    last = dot(0, float(y[0]))
    for c, value in enumerate(np.interp(grid, x, y)):
        if c % 4 == 0:
            dot(c, 0.0)
        row = dot(c, value)
        for between in range(min(row, last) + 1, max(row, last)):
            cells[between // 4, c // 2] |= DOTS[between % 4][c % 2]
        last = row
    labels = [f"{high:.3g}", *[""] * (rows - 2), f"{low:.3g}"]
    wide = max(len(label) for label in labels)
    lines = [
        f"{label.rjust(wide)} {''.join(chr(0x2800 + cell) for cell in line)}"
        for label, line in zip(labels, cells, strict=True)
    ]
    foot = f"{x[0]:g} s".ljust(columns - 6) + f"{x[-1]:.3g} s".rjust(6)
    return "\n".join([*lines, " " * (wide + 1) + foot])
