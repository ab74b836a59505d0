"""What a rehearsal leaves behind: `rehearsal.json`, its table `rehearsal.csv`, and the page `report.html`."""

from __future__ import annotations

import csv
import io
import json
import math
from pathlib import Path
from typing import Any

from realitygap.diagnose.candidates.suspects import neutral
from realitygap.diagnose.data.changes import Change, Suspect
from realitygap.diagnose.data.units import unit_there
from realitygap.diagnose.rehearse.page import label, off_by, sentence, words, write_page
from realitygap.diagnose.rehearse.planting import FINER, planted
from realitygap.diagnose.rehearse.rehearse import Rehearsal, Tried, said
from realitygap.diagnose.rehearse.visible import LARGEST, Confusable, Visible, within_law
from realitygap.diagnose.result.story_text import listed
from realitygap.files.errors import spared
from realitygap.files.interrupted import last
from realitygap.files.spreadsheet import as_words
from realitygap.files.whole import write_whole
from realitygap.robot.effects import EFFECTS

COLUMNS = (
    "effect", "target", "parameter", "unit", "model", "seen_from", "told_apart_from", "confused_with", "searches",
    "searched_from",
)  # fmt: skip


def write_rehearsal(result: Rehearsal, out: Path) -> None:
    """Write the table, the data and, last, the page into a result folder: a page that fails costs no result."""
    content = to_json(result)
    with last():
        write_whole(out / "rehearsal.csv", _csv(content))
        text = json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False)
        write_whole(out / "rehearsal.json", text + "\n")
        with spared("the page", result.notes):
            write_page(result, content, out)


def summary(result: Rehearsal) -> list[str]:
    """Lines for the terminal: from which size on every effect shows, and what it could be taken for."""
    content = to_json(result)
    lines = [sentence(result)]
    for row in content["detection"]:
        seen = (
            f"shows from {words(row['seen_from'])}{off_by(row)}"
            if row["seen_from"]
            else f"does not show up to {words(row['largest_tried'])}"
        )
        twins = [label(c) for c in row["confused_with"] if c["up_to"] is None]
        lines.append(f"  {label(row)}: {seen}{f'; could always be {listed(twins)}' if twins else ''}")
    lines += [f"  {said(t)}" for t in result.tried]
    return [*lines, *(f"  {note}" for note in result.notes)]


def to_json(result: Rehearsal) -> dict[str, Any]:
    """The content of `rehearsal.json`. A size that is never reached is null."""
    problem = result.problem
    return {
        "schema": 1,
        "scenario": problem.file.scenario.name,
        "synthetic": True,
        "engines": {"search": problem.engine, "robot": result.robot},
        "finer_step": FINER,
        "nothing_planted": {
            "train": _round(math.sqrt(result.quiet[0])),
            "held_out": _round(math.sqrt(result.quiet[1])),
            "unit": "floor-weighted rms, 1 is the floor",
            "named": [_suspect(s) for t in result.tried if t.planted is None for s in t.named],
        },
        "detection": [_row(result, v) for v in result.found],
        "confusion": [_confusable(result, c) for c in result.confusables],
        "searches": [_tried(result, t) for t in result.tried],
        "left_out": result.left_out,
        "impossible": result.impossible,
        "notes": result.notes,
        "split": problem.split,
    }


def size(result: Rehearsal, suspect: Suspect, factor: float) -> dict[str, dict[str, Any]] | None:
    """The parameters that a size changes: total, change and unit; None for a size beyond all reason."""
    return _values(result, planted(result.problem, suspect, factor)) if factor <= LARGEST else None


def _values(result: Rehearsal, change: Change) -> dict[str, dict[str, Any]]:
    zero, out = neutral(result.problem.plant, change.suspect), {}
    for p in EFFECTS[change.suspect.effect].parameters:
        value = change.parameters[p.name]
        if not p.shape and value != zero[p.name]:
            own = zero[p.name]
            absent = p.absent is not None and not (math.isfinite(own) and own)
            moved = value if absent or not math.isfinite(own) else value - own
            unit = unit_there(result.problem, change.suspect, p)
            model = _round(own) if math.isfinite(own) and not absent else None
            out[p.name] = {"value": _round(value), "change": _round(moved), "model": model, "unit": unit}
    return out


def told_apart_from(result: Rehearsal, seen: Visible) -> float:
    """The size from which on nothing else explains an effect, but for twins; in first sizes."""
    others = [c.apart_from for c in result.confusables if c.planted == seen.suspect and math.isfinite(c.apart_from)]
    return max([seen.factor, *others])


def _row(result: Rehearsal, seen: Visible) -> dict[str, Any]:
    own = [t for t in result.tried if t.planted is not None and t.planted.suspect == seen.suspect]
    confused = [c for c in result.confusables if c.planted == seen.suspect and c.apart_from > seen.factor]
    return {
        **_suspect(seen.suspect),
        "seen_from": size(result, seen.suspect, seen.factor),
        "laws_off_by": within_law(result.problem, seen.change) if seen.seen else 0.0,
        "told_apart_from": size(result, seen.suspect, told_apart_from(result, seen)) if seen.seen else None,
        "largest_tried": _values(result, seen.change),
        "confused_with": [
            {**_suspect(c.other), "up_to": size(result, c.planted, c.apart_from), "share": _round(c.share)}
            for c in confused
        ],
        "searches": len(own),
        "searched_from": size(result, seen.suspect, searched_from(own)),
    }


def searched_from(tried: list[Tried]) -> float:
    """The smallest size at which the full search was right, and at all larger ones that were tried; in first sizes."""
    out = math.inf
    for t in sorted(tried, key=lambda t: -t.factor):
        if not t.right:
            break
        out = t.factor
    return out


def _confusable(result: Rehearsal, c: Confusable) -> dict[str, Any]:
    return {
        "planted": _suspect(c.planted),
        "other": _suspect(c.other),
        "share": _round(c.share),
        "told_apart_from": size(result, c.planted, c.apart_from),
    }


def _tried(result: Rehearsal, t: Tried) -> dict[str, Any]:
    return {
        "planted": None if t.planted is None else {**_suspect(t.planted.suspect), "size": _values(result, t.planted)},
        "named": [_suspect(s) for s in t.named],
        "cannot_tell_from": [_suspect(s) for s in t.listed],
        "outcome": t.outcome,
    }


def _suspect(s: Suspect) -> dict[str, Any]:
    return {"effect": s.effect, "target": s.target if isinstance(s.target, str) else list(s.target)}


def _csv(content: dict[str, Any]) -> str:
    """The detection table: one row per effect and target, sizes as the change of the first parameter that moves."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    for row in content["detection"]:
        name, told = next(iter(row["largest_tried"].items()), ("", {"unit": "", "model": None}))

        def change(what: str, row: dict[str, Any] = row, name: str = name) -> Any:
            return "" if not row[what] or name not in row[what] else row[what][name]["change"]

        target = row["target"] if isinstance(row["target"], str) else " ".join(row["target"])
        others = " ".join(f"{c['effect']}@{_joined(c['target'])}" for c in row["confused_with"])
        model = "" if told["model"] is None else told["model"]
        numbers = (change("seen_from"), change("told_apart_from"), others, row["searches"], change("searched_from"))
        writer.writerow((row["effect"], as_words(target), name, told["unit"], model, *numbers))
    return text.getvalue()


def _joined(target: str | list[str]) -> str:
    return target if isinstance(target, str) else "+".join(target)


def _round(value: float) -> float:
    return float(f"{value:.4g}")
