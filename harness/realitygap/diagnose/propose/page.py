"""The page of a proposal: each motion with its limits, what the explanations predict, and the odds before and after."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from markupsafe import Markup

from realitygap.diagnose.propose.design import Answer
from realitygap.diagnose.propose.explanations import Question
from realitygap.diagnose.propose.figure import figure
from realitygap.diagnose.propose.proposal import Proposal, Proposed, Weak
from realitygap.diagnose.propose.words import SURE, expected, half, now, one_sided
from realitygap.diagnose.rehearse.page import label, words
from realitygap.diagnose.result.story_text import interval, listed, quantity, suspect_label
from realitygap.files.whole import write_whole
from realitygap.page.shell import render
from realitygap.page.style import engine_label


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
        virtual=result.problem.file.scenario.virtual,
        cards=cards,
        questions=[(str(q), now(q), q in result.hopeless) for q in result.open.questions],
        limits=_limits(result),
        engine=engine_label(result.problem.engine),
        notes=result.notes,
        shown=[(label(r), words(r["seen_from"]) if r["seen_from"] else "") for r in content["shows"]],
    )
    path = out / "report.html"
    write_whole(path, text)
    return path


def _card(result: Proposal, proposed: Proposed, told: dict[str, Any]) -> dict[str, Any]:
    reached = result.reached(proposed)
    worst = min(reached, key=lambda x: x[1].least, default=None)
    return {
        **told,
        "engines": listed([engine_label(e) for e in proposed.engines]) if proposed.engines else "no engine",
        "figure": Markup(figure(result, proposed, worst[0] if worst else None)) if result.predictions else "",
        "shown": str(worst[0]) if worst else "",
        "weak": [_weak(w) for w in proposed.weak],
        "rows": [_row(q, a) for q, a in reached],
        "enough": all(a.least >= SURE and not any(a.alike) for _, a in reached),
    }


def _row(question: Question, answer: Answer) -> dict[str, str]:
    return {
        "question": str(question),
        "now": now(question),
        "then": expected(question, answer),
        "if": one_sided(question, answer),
        "mood": "better" if answer.least >= SURE else "worse",
    }


def _limits(result: Proposal) -> list[dict[str, str]]:
    rows = []
    for j, joint in enumerate(result.problem.plant.model.joints):
        unit, scale, force = ("mm", 1e3, "N") if joint.prismatic else ("rad", 1.0, "N·m")
        low, high, speed = (
            scale * float(x[j]) for x in (result.limits.lower, result.limits.upper, result.limits.speed)
        )
        effort = float(result.limits.effort[j])
        rows.append(
            {
                "joint": joint.name,
                "position": interval(low, high, unit),
                "speed": quantity(speed, f"{unit}/s", short=True),
                "effort": quantity(effort, force) if np.isfinite(effort) else "not known",
            }
        )
    return rows


def _weak(weak: Weak) -> dict[str, str]:
    name = weak.parameter.replace("_", " ") if len(weak.suspect.kind.parameters) > 1 else ""
    return {
        "what": suspect_label(weak.suspect) + (f", {name}" if name else ""),
        "value": quantity(weak.value, weak.unit, short=True),
        "now": f"± {quantity(weak.now, weak.unit, short=True, digits=2)}",
        "then": f"± {quantity(weak.then, weak.unit, short=True, digits=2)}",
        "half": half(weak),
    }
