"""`realitygap diagnose`: from a scenario to `diagnosis.json`, the page and the mended model."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from realitygap.check import certain
from realitygap.diagnose.data.pool import Pool
from realitygap.diagnose.data.problem import build_problem
from realitygap.diagnose.result.diagnosis import Diagnosis, diagnose
from realitygap.diagnose.result.revise import write_revised
from realitygap.diagnose.result.story import write_story
from realitygap.diagnose.search.found import name
from realitygap.files.progress import Progress
from realitygap.files.whole import write_whole
from realitygap.scenario.engine_names import engine_names
from realitygap.scenario.file import ScenarioFile, load_scenario

SEARCH = "mujoco"
"""The engine to search in where none is asked for: the fastest."""


def run_diagnosis(
    path: Path, names: Sequence[str], out: Path, progress: Progress, workers: int | None = None
) -> Diagnosis:
    """Diagnose a scenario and write what was found.

    Args:
        path: the scenario file.
        names: engines: the first one searches, all confirm; empty: MuJoCo searches and all installed confirm.
        out: the result folder.
        progress: told what is being done.
        workers: processes; None for one per core.

    Raises:
        InputError: for a scenario that cannot be diagnosed; nothing is written then.
    """
    result = diagnosed(load_scenario(path), names, progress, workers)
    write_diagnosis(result, out)
    return result


def diagnosed(file: ScenarioFile, names: Sequence[str], progress: Progress, workers: int | None = None) -> Diagnosis:
    """The same without writing anything."""
    chosen = engine_names(names)
    warnings = certain(file)
    first = chosen[0] if names or SEARCH not in chosen else SEARCH
    problem = build_problem(file, first)
    with Pool(problem, workers) as pool:
        result = diagnose(pool, chosen, progress.say)
    result.notes[:0] = [f"likely a mistake: {m.text}" for m in warnings]
    return result


def write_diagnosis(result: Diagnosis, out: Path) -> None:
    """Write `revised/`, the page with its figures and, last, `diagnosis.json`."""
    if result.found.fit.changes:
        write_revised(result.problem, result.found.fit.changes, out / "revised")
    write_story(result, out)
    text = json.dumps(result.to_json(), indent=1, ensure_ascii=False, allow_nan=False, default=float)
    write_whole(out / "diagnosis.json", text + "\n")


def _parameter(name: str, told: dict[str, Any]) -> str:
    """A parameter with its 95 % interval, where it was fitted, and its unit."""
    interval = f"[{told['low']:.4g}, {told['high']:.4g}]" if told["low"] < told["high"] else ""
    return " ".join(part for part in (name, f"{told['value']:.4g}", interval, told["unit"]) if part)


def summary(result: Diagnosis) -> list[str]:
    """Lines for the terminal: verdict, findings with their intervals, what cannot be told apart, what to record."""
    content = result.to_json()
    gap = content["gap"]
    lines = [
        f"{content['verdict']}: held-out gap {gap['held_out']['before']:g} -> {gap['held_out']['after']:g} "
        "(floor-weighted rms, 1 is the floor)"
    ]
    for finding, change in zip(content["findings"], result.found.fit.changes, strict=True):
        values = ", ".join(_parameter(n, p) for n, p in finding["parameters"].items())
        before, after = finding["held_out"]["before"], finding["held_out"]["after"]
        lines.append(f"  {name(change.suspect)}: {values}; held out {before:g} -> {after:g}")
        for engine, pair in finding["engines"].items():
            lines.append(f"    {engine}: {pair['before']:g} -> {pair['after']:g}")
        for rival in result.rivals.get(change.suspect, []):
            lines.append(f"    cannot be told from {name(rival.suspect)}: {rival.why}")
    lines += [
        f"  worse: {w['signal']} of {w['joint']}: {w['before']:g} -> {w['after']:g} {w['unit']}"
        for w in content["worsened"]
    ]
    lines += [f"  sensor: {sentence}" for sentence in content["sensor_faults"]]
    lines += [f"  {note}" for note in content["notes"]]
    if content["split"]:
        lines.append(f"  {content['split']}")
    if content["experiment"]:
        lines.append(f"  to record next: {content['experiment']}")
    return lines
