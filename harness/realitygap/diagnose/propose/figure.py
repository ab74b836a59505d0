"""The figure of a proposed motion: the command within its limits, what both sides of a question predict, and where."""

from __future__ import annotations

from collections.abc import Sequence

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from realitygap.compare.gap import unit_of
from realitygap.diagnose.data.case import JOINT_SIGNALS
from realitygap.diagnose.likelihood.whitening import spans
from realitygap.diagnose.propose.explanations import Question
from realitygap.diagnose.propose.predict import Predictions
from realitygap.diagnose.propose.proposal import Proposal, Proposed
from realitygap.diagnose.result.diagnosis import Z95
from realitygap.diagnose.result.story_figures import AFTER, BEFORE, INK, LINE, MUTED, STYLE, svg
from realitygap.page.style import unit_label
from realitygap.robot.drive import Array

SIDES = (AFTER, BEFORE)
"""Colours of the two sides of a question."""
CLOSE_UP = 1.0
"""Length of a close-up [s]."""


def figure(result: Proposal, proposed: Proposed, question: Question | None) -> str:
    """The command within its limits; what both sides predict where they part most; and how far apart they are. SVG.

    Without a question: what the named model predicts, and how far its values leave that open.
    """
    predictions = result.predictions
    assert predictions is not None
    numbers = (0,) if question is None else (question.one, question.other)
    names = ("the named model",) if question is None else question.names
    joint, signal = _telling(result, predictions, proposed.case, numbers)
    prismatic = result.problem.plant.model.joints[joint].prismatic
    unit, scale = unit_of(signal, prismatic)
    way, place = unit_of("position", prismatic)
    time, both, sigma = _sides(result, predictions, proposed.case, numbers, joint, signal)
    motion = proposed.motion
    apart = (
        both[0][0] - both[1][0] if question else np.sqrt(np.maximum((both[0][1] / Z95) ** 2 - sigma**2, 0.0))
    ) / sigma
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(9.2, 5.4))
        grid = figure.add_gridspec(3, 2, width_ratios=[5, 2], height_ratios=[3, 4, 2])
        middle = figure.add_subplot(grid[1, 0])
        top, low = (figure.add_subplot(grid[k, 0], sharex=middle) for k in (0, 2))
        near = figure.add_subplot(grid[:2, 1])
        for limit in (result.limits.lower[joint], result.limits.upper[joint]):
            top.axhline(place * limit, color=MUTED, linewidth=1.0, linestyle=(0, (4, 2)))
        top.plot(motion.time, place * motion.value[:, joint], color=INK, linewidth=1.2)
        top.set_ylabel(f"command [{unit_label(way)}]")
        _segments(top, proposed)
        for (mean, band), name, colour in zip(both, names, SIDES, strict=False):
            for axes in (middle, near):
                low_, high = scale * (mean - band), scale * (mean + band)
                axes.fill_between(time, low_, high, color=colour, alpha=0.22, linewidth=0)
                axes.plot(time, scale * mean, color=colour, linewidth=1.2, label=name)
        middle.set_ylabel(f"{signal} [{unit_label(unit)}]")
        _close_up(near, time, [scale * side for pair in both for side in (pair[0] - pair[1], pair[0] + pair[1])], apart)
        low.axhspan(-1, 1, color=MUTED, alpha=0.25, linewidth=0)
        low.plot(time, apart, color=INK, linewidth=0.9)
        low.set_ylabel("difference\n[floors]" if question else "uncertain\n[floors]")
        low.set_xlabel("time [s]")
        figure.align_ylabels([top, middle, low])
        figure.legend(*middle.get_legend_handles_labels(), loc="outside upper left", ncols=2, frameon=False)
        return svg(figure, f"{motion.name}: the command, and what {' and '.join(names)} predicts")


def _close_up(axes: Axes, time: Array, edges: Sequence[Array], apart: Array) -> None:
    """The second in which two sides part most."""
    middle = float(time[int(np.argmax(np.abs(apart)))])
    start = min(max(middle - 0.5 * CLOSE_UP, float(time[0])), float(time[-1]) - CLOSE_UP)
    inside = (time >= start) & (time <= start + CLOSE_UP)
    low, high = min(float(e[inside].min()) for e in edges), max(float(e[inside].max()) for e in edges)
    axes.set_xlim(start, start + CLOSE_UP)
    axes.set_ylim(low - 0.05 * (high - low), high + 0.05 * (high - low))
    axes.set_title("close up", loc="left")
    axes.set_xlabel("time [s]")


def _segments(axes: Axes, proposed: Proposed) -> None:
    """Where one segment ends and the next begins."""
    ends = np.cumsum([len(s.value) for s in proposed.motion.segments]) * proposed.motion.period
    for end in ends[:-1]:
        axes.axvline(end, color=LINE, linewidth=1.0)


def _telling(result: Proposal, predictions: Predictions, case: int, numbers: Sequence[int]) -> tuple[int, str]:
    """The joint and the signal in which explanations part most, or in which the one is least certain, in floors."""
    judged = np.flatnonzero(result.problem.judged)
    best, where = -1.0, (int(judged[0]), "position")
    for channel, part in spans(predictions.channels):
        if channel.case == case and channel.signal in JOINT_SIGNALS:
            if len(numbers) > 1:
                apart = predictions.expected(numbers[0], part) - predictions.expected(numbers[1], part)
            else:
                apart = predictions.uncertain(0, part)
            far = float(np.mean((apart / np.hypot(channel.noise, channel.slow)) ** 2))
            if far > best:
                best, where = far, (int(judged[channel.column]), channel.signal)
    return where


def _sides(
    result: Proposal, predictions: Predictions, case: int, numbers: Sequence[int], joint: int, signal: str
) -> tuple[Array, list[tuple[Array, Array]], Array]:
    """Times (t,), of every side what is expected with half a 95 % band, and the floor. Shapes (t,)."""
    column = int(np.sum(result.problem.judged[:joint]))
    for channel, part in spans(predictions.channels):
        if (channel.case, channel.signal, channel.column) == (case, signal, column):
            sigma = np.hypot(channel.noise, channel.slow)
            sides = [(predictions.expected(k, part), Z95 * predictions.uncertain(k, part)) for k in numbers]
            return channel.time, [(mean, np.hypot(band, Z95 * sigma)) for mean, band in sides], sigma
    raise LookupError(signal)
