"""The page of a proposal: each motion with its limits, what the explanations predict, and the odds before and after."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from markupsafe import Markup
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from realitygap.diagnose.data.case import JOINT_SIGNALS
from realitygap.diagnose.propose.design import Answer
from realitygap.diagnose.propose.explanations import Question
from realitygap.diagnose.propose.predict import Predictions
from realitygap.diagnose.propose.proposal import Proposal, Proposed
from realitygap.diagnose.propose.words import SURE, expected, now
from realitygap.diagnose.result.diagnosis import Z95
from realitygap.diagnose.result.story_figures import AFTER, BEFORE, INK, LINE, MUTED, STYLE, svg
from realitygap.diagnose.result.story_text import listed
from realitygap.files.whole import write_whole
from realitygap.page.shell import render
from realitygap.page.style import engine_label, unit_label
from realitygap.robot.drive import Array

UNITS = {"position": "deg", "velocity": "deg/s", "effort": "N·m"}
PRISMATIC = {"position": "mm", "velocity": "mm/s", "effort": "N"}
SIDES = (AFTER, BEFORE)
"""Colours of the two sides of a question."""
CLOSE = 1.0
"""Length of a close-up [s]."""


def write_page(result: Proposal, content: dict[str, Any], out: Path) -> Path:
    """Write `report.html`. Returns it.

    Args:
        result: the proposal.
        content: what `proposal.json` says of it.
        out: the result folder.
    """
    cards = [_card(result, p, told) for p, told in zip(result.proposed, content["motions"], strict=True)]
    text = render(
        "realitygap.diagnose.propose",
        "proposal.html.j2",
        title=content["scenario"],
        cards=cards,
        questions=[(str(q), now(q), q in result.hopeless) for q in result.open.questions],
        limits=_limits(result),
        engine=engine_label(result.problem.engine),
        notes=result.notes,
    )
    path = out / "report.html"
    write_whole(path, text)
    return path


def _card(result: Proposal, proposed: Proposed, told: dict[str, Any]) -> dict[str, Any]:
    reached = result.reached(proposed)
    worst = min(reached, key=lambda x: x[1].least)
    return {
        **told,
        "engines": listed([engine_label(e) for e in proposed.engines]) if proposed.engines else "no engine",
        "figure": Markup(_figure(result, proposed, worst[0])),
        "shown": str(worst[0]),
        "rows": [_row(q, a) for q, a in reached],
        "enough": worst[1].least >= SURE,
    }


def _row(question: Question, answer: Answer) -> dict[str, str]:
    return {
        "question": str(question),
        "now": now(question),
        "then": expected(answer),
        "mood": "better" if answer.least >= SURE else "worse",
    }


def _limits(result: Proposal) -> list[dict[str, str]]:
    rows = []
    for j, joint in enumerate(result.problem.plant.model.joints):
        unit, scale = ("mm", 1e3) if joint.prismatic else ("°", 180 / np.pi)
        low, high, speed = (
            scale * float(x[j]) for x in (result.limits.lower, result.limits.upper, result.limits.speed)
        )
        effort = float(result.limits.effort[j])
        force = "N" if joint.prismatic else "N·m"
        rows.append(
            {
                "joint": joint.name,
                "position": f"{low:.1f} to {high:.1f} {unit}",
                "speed": f"{speed:.0f} {unit}/s",
                "effort": f"{effort:.3g} {force}" if np.isfinite(effort) else "not known",
            }
        )
    return rows


def _figure(result: Proposal, proposed: Proposed, question: Question) -> str:
    """The command within its limits; what both sides predict where they part most; and how far apart they are. SVG."""
    predictions = result.predictions
    assert predictions is not None
    joint, signal = _telling(result, predictions, proposed.case, question)
    prismatic = result.problem.plant.model.joints[joint].prismatic
    unit = (PRISMATIC if prismatic else UNITS)[signal]
    place, way = (1e3, "mm") if prismatic else (180 / np.pi, "deg")
    scale = 1.0 if signal == "effort" else place
    time, both, sigma = _sides(result, predictions, proposed.case, question, joint, signal)
    motion = proposed.motion
    apart = (both[0][0] - both[1][0]) / sigma
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
        for (mean, band), name, colour in zip(both, question.names, SIDES, strict=True):
            for axes in (middle, near):
                low_, high = scale * (mean - band), scale * (mean + band)
                axes.fill_between(time, low_, high, color=colour, alpha=0.22, linewidth=0)
                axes.plot(time, scale * mean, color=colour, linewidth=1.2, label=name)
        middle.set_ylabel(f"{signal} [{unit_label(unit)}]")
        _close_up(near, time, [scale * side for pair in both for side in (pair[0] - pair[1], pair[0] + pair[1])], apart)
        low.axhspan(-1, 1, color=MUTED, alpha=0.25, linewidth=0)
        low.plot(time, apart, color=INK, linewidth=0.9)
        low.set_ylabel("difference\n[floors]")
        low.set_xlabel("time [s]")
        figure.align_ylabels([top, middle, low])
        figure.legend(*middle.get_legend_handles_labels(), loc="outside upper left", ncols=2, frameon=False)
        return svg(figure, f"{motion.name}: command, and what {question.names[0]} and {question.names[1]} predict")


def _close_up(axes: Axes, time: Array, edges: Sequence[Array], apart: Array) -> None:
    """The second in which two sides part most."""
    middle = float(time[int(np.argmax(np.abs(apart)))])
    start = min(max(middle - 0.5 * CLOSE, float(time[0])), float(time[-1]) - CLOSE)
    inside = (time >= start) & (time <= start + CLOSE)
    low, high = min(float(e[inside].min()) for e in edges), max(float(e[inside].max()) for e in edges)
    axes.set_xlim(start, start + CLOSE)
    axes.set_ylim(low - 0.05 * (high - low), high + 0.05 * (high - low))
    axes.set_title("close up", loc="left")
    axes.set_xlabel("time [s]")


def _segments(axes: Axes, proposed: Proposed) -> None:
    """Where one segment ends and the next begins."""
    ends = np.cumsum([len(s.value) for s in proposed.motion.segments]) * proposed.motion.period
    for end in ends[:-1]:
        axes.axvline(end, color=LINE, linewidth=1.0)


def _telling(result: Proposal, predictions: Predictions, case: int, question: Question) -> tuple[int, str]:
    """The joint and the signal in which two explanations part most, in floors."""
    apart = predictions.expected(question.one) - predictions.expected(question.other)
    judged = np.flatnonzero(result.problem.judged)
    best, at, where = -1.0, 0, (int(judged[0]), "position")
    for channel in predictions.channels:
        part = apart[at : at + len(channel.time)]
        at += len(channel.time)
        if channel.case == case and channel.signal in JOINT_SIGNALS:
            far = float(np.mean((part / np.hypot(channel.noise, channel.slow)) ** 2))
            if far > best:
                best, where = far, (int(judged[channel.column]), channel.signal)
    return where


def _sides(
    result: Proposal, predictions: Predictions, case: int, question: Question, joint: int, signal: str
) -> tuple[Array, list[tuple[Array, Array]], Array]:
    """Times (t,), of both sides what is expected with half a 95 % band, and the floor. Shapes (t,)."""
    column = int(np.sum(result.problem.judged[:joint]))
    at = 0
    for channel in predictions.channels:
        part = slice(at, at + len(channel.time))
        at += len(channel.time)
        if (channel.case, channel.signal, channel.column) == (case, signal, column):
            sides = []
            sigma = np.hypot(channel.noise, channel.slow)
            for number in (question.one, question.other):
                wide = np.hypot(predictions.uncertain(number)[part], sigma)
                sides.append((predictions.expected(number)[part], Z95 * wide))
            return channel.time, sides, sigma
    raise LookupError(signal)
