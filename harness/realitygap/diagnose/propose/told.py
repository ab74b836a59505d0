"""What a proposal starts from: a diagnosis that was written, or a scenario that is diagnosed first."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from realitygap.diagnose.candidates.suspects import suspects
from realitygap.diagnose.candidates.told import told_by_recordings
from realitygap.diagnose.data.changes import Change, Suspect
from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.fit.fit import Fit
from realitygap.diagnose.fit.motions import residual
from realitygap.diagnose.likelihood.floors import Floors, measure
from realitygap.diagnose.propose.explanations import MOST, Open, left_open
from realitygap.diagnose.result.diagnosis import SCHEMA
from realitygap.diagnose.search.evidence import Scored
from realitygap.diagnose.search.exchange import Exchanged, exchanged
from realitygap.diagnose.search.rivals import ODDS
from realitygap.diagnose.search.round import Round, Say
from realitygap.diagnose.search.search import needed, search
from realitygap.files.errors import InputError
from realitygap.files.found import shown
from realitygap.files.plain_file import read_written
from realitygap.robot.effects import EFFORT_MAP
from realitygap.robot.effort_map import Table

DIAGNOSIS = "diagnosis.json"


@dataclass(frozen=True)
class Origin:
    """What a proposal starts from.

    Attributes:
        scenario: the file.
        engine: in which the diagnosis searched; empty where none was made.
        findings: as `diagnosis.json` has them; None where none was made.
        adjusted: what its model has besides, likewise.
    """

    scenario: Path
    engine: str = ""
    findings: list[dict[str, Any]] | None = None
    adjusted: tuple[dict[str, Any], ...] = ()


def origin_of(path: Path) -> Origin:
    """The start that a path means: a scenario file, a `diagnosis.json`, or the folder of one.

    Raises:
        InputError: for a diagnosis that cannot be read, or whose scenario is not there.
    """
    file = path / DIAGNOSIS if path.is_dir() else path
    if file.suffix != ".json":
        return Origin(path)
    if not file.exists():
        raise InputError(f"{path}: holds no {DIAGNOSIS}; expected a scenario file or the folder of a diagnosis")
    try:
        content = json.loads(read_written(file))
        version = content.get("schema", SCHEMA)
        scenario, engine = Path(content["scenario_file"]), str(content["engines"][0])
        findings, adjusted = list(content["findings"]), tuple(content.get("adjusted", ()))
    except (ValueError, KeyError, TypeError, IndexError, AttributeError, RecursionError):
        raise InputError(
            f"{file}: is no diagnosis that names its scenario; expected what `realitygap diagnose` writes"
        ) from None
    if version != SCHEMA:
        raise InputError(f"{file}: schema: found {shown(version)}; expected {SCHEMA}: diagnose it again")
    if not scenario.is_file():
        raise InputError(f"{file}: scenario_file: {scenario} does not exist; expected the scenario that was diagnosed")
    return Origin(scenario, engine, findings, adjusted)


def mended(problem: Problem, origin: Origin, file: Path) -> list[Change] | None:
    """The model of a diagnosis as changes of its problem; None where none was made. What is adjusted in it stays as it
    is: no motion is asked for it.

    Raises:
        InputError: for a finding that the scenario has no place for.
    """
    if origin.findings is None:
        return None
    changes, named = found_changes(problem, [*origin.findings, *origin.adjusted], file), len(origin.findings)
    return [*changes[:named], *(replace(c, free=()) for c in changes[named:])]


def found_changes(problem: Problem, findings: Sequence[dict[str, Any]], file: Path) -> list[Change]:
    """The findings of a diagnosis as changes of its problem.

    Raises:
        InputError: for a finding that the scenario has no place for.
    """
    everyone = {(s.effect, s.target): s for s in suspects(problem)}
    out = []
    for told in findings:
        target = told["target"] if isinstance(told["target"], str) else tuple(told["target"])
        if told["effect"] == EFFORT_MAP.name and target in problem.plant.model.joint_names:
            out.append(_tabulated(told, problem.plant.model.joint_names.index(target)))
            continue
        suspect = everyone.get((told["effect"], target))
        if suspect is None:
            raise InputError(
                f"{file}: found {told['effect']} at {target}, for which the scenario has no place; expected the same "
                "scenario as was diagnosed"
            )
        parameters = told["parameters"]
        left_out = {p.name: np.inf if p.absent is None else p.absent for p in suspect.kind.parameters}
        values = left_out | {n: float(p["value"]) for n, p in parameters.items()}
        free = tuple(n for n, p in parameters.items() if p["low"] < p["high"])
        out.append(Change(suspect, tuple(values.items()), free))
    return out


def _tabulated(told: dict[str, Any], joint: int) -> Change:
    """The change of an effort that no law explains, which is no suspect before its table is known."""
    variables, knots, values = (told["parameters"][name]["value"] for name in ("variables", "knots", "values"))
    table = Table(tuple(variables), tuple(tuple(map(float, row)) for row in knots))
    flat = map(float, np.ravel(values))
    suspect = Suspect(EFFORT_MAP.name, told["target"], (joint,), table=table)
    return Change(suspect, tuple(zip(table.names, flat, strict=True)), table.names)


def opened(simulations: Simulations, changes: Sequence[Change] | None, say: Say) -> tuple[Open, Floors]:
    """What the recordings leave open, and the floors of the named model.

    Args:
        simulations: of the problem.
        changes: the model of a diagnosis; None to search now.
        say: told what is being done.
    """
    problem = simulations.problem
    everyone = suspects(problem)
    told = told_by_recordings(problem, everyone)
    if changes is None:
        say("what the recordings leave open: a diagnosis first")
        at = search(simulations, everyone, told, say).best.fit
    else:
        seen = {c.suspect for c in told}  # by the recordings themselves, not fitted
        changes = [replace(c, free=()) if c.suspect in seen else c for c in changes]
        first = residual(simulations, changes, problem.of("train"))
        if first is None:
            raise InputError(f"{problem.file.path}: what the diagnosis found cannot be simulated in {problem.engine}")
        at = Fit(tuple(changes), first)
    say("what stands beside the findings")
    unchanged = residual(simulations, told, problem.of("train"))
    nothing = at if unchanged is None else Fit(tuple(told), unchanged)
    round_ = Round(simulations, at, everyone, needed(len(everyone)), nothing, say)
    rivals = exchanged(round_, [c.suspect for c in at.changes if not c.free], Exchanged()).rivals
    return left_open(round_.now, rivals, _unnamed(round_)), measure(simulations, round_.now.fit.changes)


def _unnamed(round_: Round) -> dict[Suspect, Scored]:
    """Models with one more effect, which the recordings neither show nor exclude: those of most predicted gain."""
    now, least = round_.now, 0.0 if not round_.now.fit.changes else ODDS
    likely = {p.block.suspect: p for p in reversed(round_.candidates) if p.gain > least}
    fitted = {}
    for p in sorted(likely.values(), key=lambda p: -p.gain)[:MOST]:
        scored = round_.criterion.fit([*now.fit.changes, p.block.start.first])
        if scored is not None and scored.evidence - now.evidence > least:
            fitted[p.block.suspect] = scored
    return fitted
