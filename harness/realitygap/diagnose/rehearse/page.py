"""The page of a rehearsal: what shows in recordings, from which size on, what searches name, and what is confused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib as mpl
from markupsafe import Markup
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from realitygap.diagnose.rehearse.rehearse import Rehearsal
from realitygap.diagnose.result.story_figures import AFTER, INK, LINE, PAPER, STYLE, svg
from realitygap.diagnose.result.story_text import effect_label, interval, listed, quantity, suspect_label
from realitygap.files.whole import write_whole
from realitygap.page.shell import render
from realitygap.page.style import engine_label, number
from realitygap.robot.effects import EFFECTS

SHOWN = 0.02
"""A share below this stays an empty square in the confusion matrix."""
NEVER = "–"
"""Stands for a size that is never reached."""


def write_page(result: Rehearsal, content: dict[str, Any], out: Path) -> Path:
    """Write `report.html` of a rehearsal. Returns the page.

    Args:
        result: the rehearsal.
        content: what `rehearsal.json` says of it.
        out: the result folder.
    """
    path = out / "report.html"
    rows = [_row(told, content["searches"]) for told in content["detection"]]
    seen = [v for v in result.found if v.seen]
    null = next((t for t in result.tried if t.planted is None), None)
    problem, joints = result.problem, result.problem.plant.model.joint_names
    text = render(
        "realitygap.diagnose.rehearse",
        "rehearsal.html.j2",
        title=problem.file.scenario.name,
        virtual=problem.file.scenario.virtual,
        sentence=sentence(result),
        rows=rows,
        matrix=Markup(_matrix(result)) if seen else None,
        searched=_searched(result),
        checked=[suspect_label(s) for s in null.named] if null else None,
        quiet=number(content["nothing_planted"]["held_out"], 2),
        search_engine=engine_label(problem.engine),
        robot_engine=engine_label(result.robot),
        finer=f"{content['finer_step']:g}",
        runs={use: [problem.cases[i].name for i in problem.of(key)]
              for use, key in (("train", "train"), ("held_out", "held_out"))},
        left_out=result.left_out,
        impossible=[(effect_label(e), reason.split(";")[0]) for e, reason in result.impossible.items()],
        notes=result.notes,
        split=problem.split,
        disturbed=[f"{n} {number(t)}" for n, t in zip(joints, result.floors.torque, strict=True) if t],
    )  # fmt: skip
    write_whole(path, text)
    return path


def words(size: dict[str, dict[str, Any]] | None) -> str:
    """A size as people read it: from the model's own value to the planted one."""
    if not size:
        return NEVER
    parts = []
    for name, p in size.items():
        label = f"{name.replace('_', ' ')} " if len(size) > 1 else ""
        if p["model"] is None:
            parts.append(label + quantity(p["value"], p["unit"], short=True))
        else:
            parts.append(label + interval(p["model"], p["value"], p["unit"], word="→", digits=4))
    return ", ".join(parts)


def _row(told: dict[str, Any], searches: list[dict[str, Any]]) -> dict[str, Any]:
    seen = told["seen_from"] is not None
    others = [(label(c), words(c["up_to"])) for c in told["confused_with"]]
    own = [t for t in searches if t["planted"] and all(t["planted"][k] == told[k] for k in ("effect", "target"))]
    return {
        "effect": effect_label(told["effect"]),
        "target": _target(told),
        "seen": words(told["seen_from"]) if seen else "",
        "off": off_by(told).removeprefix(", "),
        "largest": words(told["largest_tried"]),
        "apart": "at once" if told["told_apart_from"] == told["seen_from"] else words(told["told_apart_from"]),
        "twins": [name for name, limit in others if limit == NEVER],
        "others": [(name, limit) for name, limit in others if limit != NEVER],
        "tried": [_attempt(t) for t in own],
    }


def _target(told: dict[str, Any]) -> str:
    target = told["target"] if isinstance(told["target"], str) else ", ".join(told["target"])
    return "all joints" if target == "*" else target


def label(told: dict[str, Any]) -> str:
    """An effect and where it sits, from the data."""
    return f"{effect_label(told['effect'])} at {_target(told)}"


def _attempt(told: dict[str, Any]) -> dict[str, str]:
    planted = told["planted"]
    others = [label(s) for s in told["named"] if any(s[k] != planted[k] for k in ("effect", "target"))]
    said = {
        "named": "named" + (f", and besides {listed(others)}" if others else ""),
        "listed": f"listed beside {listed(others)}" if others else "listed",
        "other": f"taken for {listed(others)}" if others else "",
        "nothing": "not found",
    }[told["outcome"]]
    good = told["outcome"] == "listed" or (told["outcome"] == "named" and not others)
    return {"size": words(planted["size"]), "said": said, "mood": "better" if good else "worse"}


def off_by(told: dict[str, Any]) -> str:
    """What is added to the size from which on an effect shows, where laws are off by as much; empty elsewhere."""
    return f", within the {100 * told['laws_off_by']:.0f} % that such laws are off by" if told["laws_off_by"] else ""


def sentence(result: Rehearsal) -> str:
    """What the rehearsal comes to: what shows in the recordings, and what full searches named of it."""
    seen = [v for v in result.found if v.seen]
    effects = list(dict.fromkeys(v.suspect.effect for v in seen))
    planted = list(dict.fromkeys(v.suspect.effect for v in result.found))
    twins = {c.planted for c in result.confusables if c.apart_from == float("inf")}
    sure = list(dict.fromkeys(v.suspect.effect for v in seen if v.suspect not in twins))
    text = f"Of {len(planted)} effects that can act here, {len(effects) or 'none'} would show in these recordings"
    if not effects:
        return f"{text}."
    if len(sure) == len(effects):
        text += ", each unlike all others once it is large enough"
    else:
        hidden = [effect_label(e) for e in effects if e not in sure]
        text += (
            f"; at whatever size, {listed(hidden)} {'stays' if len(hidden) == 1 else 'stay'} open to another reading"
        )
    return f"{text}. {_found(result)}"


OUTCOMES = {
    "named": "named it",
    "listed": "named something else and listed it as what that could be",
    "other": "took it for something else",
    "nothing": "named nothing",
}
"""What a full search does with what was planted, in words."""


def _found(result: Rehearsal) -> str:
    """What full searches on planted recordings found, in one sentence."""
    tried = [t for t in result.tried if t.planted is not None]
    if not tried:
        return "What a diagnosis would name of them is not known: the time was too short for a full search."
    smallest = {v.suspect: v.factor for v in result.found}
    times = [t.factor / smallest[t.planted.suspect] for t in tried if t.planted is not None]
    low, high = f"{min(times):.2g}", f"{max(times):.2g}"
    at = f"{low} times" if low == high else f"{low} to {high} times"
    done = [(sum(t.outcome == outcome for t in tried), said) for outcome, said in OUTCOMES.items()]
    counts = listed([f"{count} {said}" for count, said in done if count])
    fewer = "A diagnosis names fewer, because no law is exact: of" if any(not t.right for t in tried) else "Of"
    searches = f"{len(tried)} full search{'es' if len(tried) > 1 else ''}"
    return f"{fewer} {searches} for an effect of {at} the smallest size that shows, {counts}."


def _matrix(result: Rehearsal) -> str:
    """How much of each effect another one explains, by effect: the largest share over their targets. SVG."""
    names = [e for e in EFFECTS if any(v.seen and v.suspect.effect == e for v in result.found)]
    share: dict[tuple[str, str], float] = {}
    for c in result.confusables:
        key = (c.planted.effect, c.other.effect)
        share[key] = max(share.get(key, 0.0), c.share)
    n = len(names)
    with mpl.rc_context(STYLE | {"axes.grid": False}):
        figure = Figure(figsize=(2.6 + 0.31 * n, 1.9 + 0.27 * n))
        axes = figure.subplots()
        for i, a in enumerate(names):
            for j, b in enumerate(names):
                value = share.get((a, b))
                axes.add_patch(Rectangle((j - 0.47, i - 0.47), 0.94, 0.94, facecolor=LINE, alpha=0.35, linewidth=0))
                if value is None or value < SHOWN:
                    continue
                axes.add_patch(Rectangle((j - 0.47, i - 0.47), 0.94, 0.94, facecolor=AFTER, alpha=value, linewidth=0))
                if value >= 0.5:
                    text = "twin" if value > 0.998 else f"{100 * value:.0f}"
                    axes.text(j, i, text, ha="center", va="center", fontsize=6.5, color=INK if value < 0.75 else PAPER)
        axes.set_xlim(-0.5, n - 0.5)
        axes.set_ylim(n - 0.5, -0.5)
        axes.set_xticks(range(n), [effect_label(e) for e in names], rotation=90)
        axes.set_yticks(range(n), [effect_label(e) for e in names])
        axes.xaxis.tick_top()
        axes.xaxis.set_label_position("top")
        axes.set_xlabel("... is explained by")
        axes.set_ylabel("this effect ...")
        axes.tick_params(length=0)
        for spine in axes.spines.values():
            spine.set_visible(False)
        return svg(figure, "Which effect another one explains, in per cent")


def _searched(result: Rehearsal) -> list[tuple[str, list[tuple[str, int]]]]:
    """The confusion matrix of the full searches, sparse: planted effect -> what was named, how often."""
    out: dict[str, dict[str, int]] = {}
    for t in result.tried:
        row = out.setdefault(effect_label(t.planted.suspect.effect) if t.planted else "nothing", {})
        for s in [effect_label(s.effect) for s in t.named] or ["nothing"]:
            row[s] = row.get(s, 0) + 1
    return [(planted, sorted(row.items(), key=lambda item: -item[1])) for planted, row in out.items()]
