"""The page of a diagnosis: one file that opens offline and tells the story in order."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from markupsafe import Markup

from realitygap.compare.gap import unit_of
from realitygap.diagnose.data.changes import Change
from realitygap.diagnose.data.units import unit_there
from realitygap.diagnose.judge.closest import Closest
from realitygap.diagnose.judge.gaps import CLEAR, Shown
from realitygap.diagnose.judge.locate import Place, phases
from realitygap.diagnose.judge.steps import MANY
from realitygap.diagnose.result.diagnosis import Diagnosis, why
from realitygap.diagnose.result.story_figures import Curves, Pair, draw_curves, draw_pairs, spans
from realitygap.diagnose.result.story_files import told_files
from realitygap.diagnose.result.story_table import draw_table, value_rows
from realitygap.diagnose.result.story_text import (
    agreement,
    better,
    has,
    in_words,
    interval,
    lacks,
    model_value,
    name_label,
    own_reach,
    quantity,
    rival_label,
    rule,
    suspect_label,
    target_label,
    verdict,
)
from realitygap.files.found import counted
from realitygap.files.whole import write_whole
from realitygap.page.shell import render
from realitygap.page.style import engine_label, number, unit_label
from realitygap.page.style import quantity as in_unit
from realitygap.robot.effects import EFFECTS

SHOWN = 4
"""Joints whose curves are shown: those with the largest gap."""
FIRST = 8
"""Rows of a table of joints and signals that are seen at once; the others unfold."""
FEW = 3
"""Up to so many joints with an effect have a row each in the table of all findings; more of them share one."""
NOT_FITTED = "not fitted"
USES = {"held_out": "held out", "train": "training"}


@dataclass(frozen=True)
class _Value:
    """A fitted parameter in `unit`, its 95 % interval, and what the model had from and to: None for nothing."""

    value: float
    low: float
    high: float
    unit: str
    own: tuple[float, float] | None


def write_story(result: Diagnosis, out: Path, revised: Sequence[str] = ()) -> Path:
    """Write the page of a diagnosis into a result folder. Returns the page.

    Args:
        result: of the diagnosis.
        out: the result folder.
        revised: the files of the mended model, by their paths in the folder.
    """
    path = out / "report.html"
    files = told_files(result, revised)
    write_whole(path, render("realitygap.diagnose.result", "story.html.j2", **_story(result), revised=files))
    return path


def _story(result: Diagnosis) -> dict[str, Any]:
    problem = result.problem
    changes = result.changes
    gaps = {use: [number(gap) for gap in result.gap(use)] for use in USES}
    findings = [_finding(result, c) for c in changes]
    return {
        "title": problem.file.scenario.name,
        "meta": _meta(result),
        "virtual": problem.file.scenario.virtual,
        "verdict": result.verdict,
        "sentence": verdict(result),
        "rule": f"{rule(result)} {agreement(result)}".rstrip(),
        "gaps": gaps,
        "mended": bool(result.mended),
        "above": max(result.gap(use)[1] for use in USES) > CLEAR,
        "cut": result.found.cut,
        "where": [_place(p) for p in result.where],
        "first": FIRST,
        "findings": findings,
        "groups": _groups(findings),
        "table": _table(findings) if len(findings) > MANY else [],
        "adjusted": _adjusted(result),
        "curves": _curves(result),
        "runs": Markup(draw_pairs(_runs(result), "Gap of every run before and after")),
        "apart": [
            (suspect_label(s), [(rival_label(r), why(r)) for r in listed])
            for s, listed in result.rivals.items()
            if listed
        ],
        "experiment": _sentences(result.experiment()),
        "proposes": not problem.file.scenario.follows and problem.file.scenario.robot.base != "free",
        "worsened": [(w.joint, w.signal, number(w.before), in_unit(w.after, w.unit)) for w in result.worsened],
        "left": [_place(p) for p in result.left],
        "faults": result.faults,
        "blamed": result.blamed,
        "closest": [_closest(result, c) for c in result.closest],
        "units": [(u.signal, number(u.before), in_unit(u.after, u.unit)) for u in result.units],
        "notes": [_begun(result, in_words(note)) for note in result.notes],
        "split": problem.split,
        "names": {use: [problem.cases[i].name for i in problem.of(use)] for use in USES},
        "repeated": sum(c.repetitions > 1 for c in problem.cases),
        "engines": [engine_label(e) for e in result.engines],
        "effects": len(EFFECTS),
    }


def _meta(result: Diagnosis) -> str:
    counts = {
        "recorded motion": len({c.experiment.name for c in result.problem.cases}),
        "joint": int(result.problem.judged.sum()),
        "engine": len(result.engines),
    }
    return " · ".join(counted(n, name) for name, n in counts.items() if n)


def _place(place: Place) -> dict[str, str]:
    return {
        "joint": place.joint,
        "signal": f"{place.signal.removeprefix('base_')} [{unit_label(place.unit)}]",
        "gap": number(place.gap),
        "noise": number(place.noise_floor),
        "numerical": number(place.numerical_floor),
        "floors": number(place.floors),
        "when": ", ".join(place.when),
    }


def _finding(result: Diagnosis, change: Change) -> dict[str, Any]:
    content = result.to_json()["findings"][result.changes.index(change)]
    effect, suspect = change.suspect.kind, change.suspect
    values: dict[str, _Value] = {}
    for p in (p for p in effect.parameters if p.name in content["parameters"]):
        unit, told = unit_there(result.problem, suspect, p), content["parameters"][p.name]
        own = own_reach(result.problem, suspect, p) if has(result.problem, suspect, p) else None
        values[p.name.replace("_", " ")] = _Value(told["value"], told["low"], told["high"], unit, own)
    done = result.shown[suspect]
    searched = f"{engine_label(result.engines[0])} (searched)"
    pairs = [Pair(searched, done.before, done.after)]
    pairs += [Pair(engine_label(e), before, after) for e, (before, after) in done.engines.items()]
    missing = [engine_label(e) for e in result.engines[1:] if e not in done.engines]
    return {
        "name": name_label(suspect),
        "command": suspect.effect,
        "target": target_label(suspect),
        "sits_at": effect.sits_at,
        "indices": suspect.indices,
        "said": lacks(result, change),
        "better": better(result, change),
        "parameters": _parameters(result, change, content["parameters"]),
        "values": values,
        "page": effect.page,
        **_step(done),
        "figure": Markup(draw_pairs(pairs, f"Held-out gap before and after {name_label(suspect)}, by engine")),
        "drawing": Markup(draw_table(result, change)) if suspect.table is not None else "",
        "missing": missing,
    }


def _step(done: Shown) -> dict[str, Any]:
    """The held-out gap before and after a step, and whether it is seen to rise."""
    before, after = number(done.before), number(done.after)
    return {"before": before, "after": after, "rises": done.after > done.before and before != after}


def _parameters(result: Diagnosis, change: Change, content: dict[str, Any]) -> list[tuple[str, str, str, str]]:
    """A row per parameter: its name, its value, its 95 % interval, and what the model had."""
    suspect, problem = change.suspect, result.problem
    rows = [] if suspect.table is None else value_rows(result, change)
    for p in (p for p in suspect.kind.parameters if p.name in content):
        unit, told = unit_there(problem, suspect, p), content[p.name]
        known = p.name in change.free or told["low"] < told["high"]
        spread = interval(told["low"], told["high"], unit) if known else NOT_FITTED
        name = p.name.replace("_", " ")
        rows.append((name, quantity(told["value"], unit), spread, model_value(problem, suspect, p)))
    return rows


def _adjusted(result: Diagnosis) -> dict[str, Any]:
    """What laws are off by: a row for every value that was fitted, and the held-out gap before and after them all."""
    rows = [
        (name_label(c.suspect), target_label(c.suspect), *row)
        for c, told in zip(result.adjusted, result.to_json()["adjusted"], strict=True)
        for row in _parameters(result, c, told["parameters"])
        if row[2] != NOT_FITTED
    ]
    if not rows:
        return {}
    done = result.shown[result.adjusted[0].suspect]
    return {"rows": rows, **_step(done)}


def _groups(found: list[dict[str, Any]]) -> list[tuple[str, list[dict[str, Any]]]]:
    """The cards of the findings; of many, those of an effect are one card together, under one title."""
    groups: list[tuple[str, list[dict[str, Any]]]] = []
    for member in found:
        alike = [other for other in found if other["name"] == member["name"]]
        if len(alike) == 1 or len(found) <= MANY:
            groups.append(("", [member]))
        elif member is alike[0]:
            groups.append((f"{member['name']} at {_places(alike)}", alike))
    return groups


def _places(found: list[dict[str, Any]]) -> str:
    """At how many joints, or links, findings are: one may be at many."""
    return f"{len({i for f in found for i in f['indices']})} {found[0]['sits_at']}s"


def _table(found: list[dict[str, Any]]) -> list[tuple[str, ...]]:
    """Every fitted value in one table, alike effects together. Of an effect at more than a few joints every parameter
    is one row, with what its values, their intervals and what the model had reach from and to.
    """
    rows: list[tuple[str, ...]] = []
    for _, members in _groups(found):
        fitted: dict[str, list[tuple[dict[str, Any], tuple[str, ...]]]] = {}
        for f in members:
            for p in f["parameters"]:
                if p[2] != NOT_FITTED:
                    fitted.setdefault(p[0], []).append((f, p))
        for name, alike in fitted.items():
            values = [f["values"][name] for f, _ in alike if name in f["values"]]
            if FEW < len(alike) == len(values) and len({v.unit for v in values}) == 1:
                first = alike[0][0]
                rows.append((first["name"], _places([f for f, _ in alike]), name, *_reach(values)))
            else:
                rows += [(f["name"], f["target"], *p) for f, p in alike]
    order = list(dict.fromkeys(f["name"] for f in found))
    return sorted(rows, key=lambda row: order.index(row[0]))


def _reach(values: list[_Value]) -> tuple[str, str, str]:
    """What values, their 95 % intervals and the model's own reach from and to, in words."""
    unit, low, high = values[0].unit, min(v.value for v in values), max(v.value for v in values)
    within = interval(min(v.low for v in values), max(v.high for v in values), unit)
    had = [end for v in values if v.own is not None for end in v.own]
    own = "none" if not had else quantity(had[0], unit) if min(had) == max(had) else interval(min(had), max(had), unit)
    return interval(low, high, unit), f"all within {within}", own


def _closest(result: Diagnosis, closest: Closest) -> tuple[str, str, str, str]:
    """A candidate that was not named: what it would be, the gap on training runs before and after, and why not."""
    said = lacks(result, closest.change)
    return said, number(closest.before), number(closest.after), closest.why


def _runs(result: Diagnosis) -> list[Pair]:
    before, after = result.costs
    return [
        Pair(
            result.problem.cases[i].name,
            float(np.sqrt(before[i])),
            float(np.sqrt(after[i])) if result.mended else None,
            "held out" if use == "held_out" else "training",
        )
        for use in USES
        for i in result.problem.of(use)
    ]


def _curves(result: Diagnosis) -> list[dict[str, Any]]:
    """One held-out and one training run for each joint with a gap; where there is none, of the first joints."""
    places: dict[str, Place | None] = {}
    problem = result.problem
    for place in result.where:
        if place.joint in problem.plant.model.joint_names:
            places.setdefault(place.joint, place)
    if not places:
        names = problem.plant.model.joint_names
        places = {n: None for j, n in enumerate(names) if problem.judged[j]}
    out = []
    for joint, worst in list(places.items())[:SHOWN]:
        j = problem.plant.model.joint_names.index(joint)
        signal, when = (worst.signal, worst.when) if worst is not None else ("position", ())
        figures = {}
        for use in USES:
            case = _telling(result, use, signal, j)
            if case is not None:
                name = problem.cases[case].name
                title = f"{signal} of {joint} in {name}: measured and simulated"
                figures[use] = (name, Markup(draw_curves(_curve(result, case, signal, j, when), title)))
        out.append({"joint": joint, "signal": signal, "when": when, "figures": figures})
    return out


def _telling(result: Diagnosis, use: str, signal: str, j: int) -> int | None:
    """The run in which this joint's gap is largest."""
    cases = [i for i in result.problem.of(use) if i in result.before and i in result.after]
    cases = [i for i in cases if signal in result.problem.signals(i)]

    def gap(i: int) -> float:
        case = result.problem.cases[i]
        delta = result.before[i][signal][:, j] - case.value(signal)[:, j]
        return float(np.nanmean((delta / result.floors.sigma(i, signal)[:, j]) ** 2))

    return max(cases, key=gap, default=None)


def _curve(result: Diagnosis, case: int, signal: str, j: int, when: tuple[str, ...]) -> Curves:
    problem = result.problem
    c = problem.cases[case]
    unit, scale = unit_of(signal, problem.plant.model.joints[j].prismatic)
    masks = phases(c, j, result.before[case])
    inside = [masks[w] for w in when if w in masks]
    return Curves(
        time=c.measured.time,
        measured=c.value(signal)[:, j] * scale,
        before=result.before[case][signal][:, j] * scale,
        after=result.after[case][signal][:, j] * scale if result.mended else None,
        sigma=result.floors.sigma(case, signal)[:, j] * scale,
        unit=unit,
        signal=signal,
        spans=spans(c.measured.time, np.any(inside, axis=0)) if inside else (),
    )


def _begun(result: Diagnosis, sentence: str) -> str:
    """A sentence with a capital, unless a name begins it."""
    names = [*result.problem.plant.model.joint_names, *(c.name for c in result.problem.cases)]
    named = any(sentence.startswith(name.split(" ")[0]) for name in names)
    return sentence if named else sentence[0].upper() + sentence[1:]


def _sentences(text: str) -> list[str]:
    return [t[0].upper() + in_words(t)[1:] for t in text.split("; ") if t]
