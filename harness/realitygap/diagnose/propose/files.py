"""What a proposal leaves behind: `proposal.json`, the page, and every motion as keyframes, commands and trajectory."""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from pydantic import BaseModel, ConfigDict

from realitygap.diagnose.propose.design import Answer
from realitygap.diagnose.propose.excitation import Excitation
from realitygap.diagnose.propose.explanations import Question
from realitygap.diagnose.propose.keyframes import animation, waypoints
from realitygap.diagnose.propose.page import write_page
from realitygap.diagnose.propose.proposal import Proposal, Proposed, Weak
from realitygap.diagnose.propose.words import now, settles
from realitygap.diagnose.rehearse.files import to_json
from realitygap.diagnose.rehearse.page import label, words
from realitygap.diagnose.rehearse.rehearse import Rehearsal
from realitygap.diagnose.result.revise import Plain, rebased
from realitygap.files.errors import spared
from realitygap.files.interrupted import last
from realitygap.files.own_files import own, remove
from realitygap.files.whole import write_whole
from realitygap.trace.trajectory import write_trajectory

SUFFIXES = {"keyframes": "json", "commands": "csv", "trajectory": "mcap", "scenario": "yaml"}
"""The files of a motion."""


class Settled(BaseModel):
    """What a motion does to a question.

    Odds are natural logarithms; `now` is for the first side, `if_one` and `if_other` for the side that is the true one.
    `same_if` names the sides that the other one does the same as, refitted: if one of these is true, its odds are those
    of being simpler, and nothing that is seen.
    """

    model_config = ConfigDict(frozen=True)
    one: str
    other: str
    now: float
    if_one: float
    if_other: float
    same_if: list[str]


class Sharpened(BaseModel):
    """What a motion does to a value of the named model: half its 95 % interval now and then, and how long one has to
    record the motion until the interval is half as wide [s], null where it never is.
    """

    model_config = ConfigDict(frozen=True)
    effect: str
    target: str | list[str]
    parameter: str
    unit: str
    value: float
    now: float
    then: float
    half_after: float | None


class MotionFile(BaseModel):
    """A proposed motion: its files, how long it takes [s], the `with` of its run, and what it will settle."""

    model_config = ConfigDict(frozen=True)
    name: str
    seconds: float
    segments: list[str]
    condition: str
    overrides: dict[str, Any]
    files: dict[str, str]
    stays_within_limits_in: list[str]
    settles: list[Settled]
    sharpens: list[Sharpened]
    says: str


class ProposalFile(BaseModel):
    """The content of `proposal.json`."""

    model_config = ConfigDict(frozen=True)
    format: int = 1
    scenario: str
    scenario_file: str
    engine: str
    pose: dict[str, float]
    limits: dict[str, dict[str, float | None]]
    open: list[str]
    out_of_reach: list[str]
    motions: list[MotionFile]
    shows: list[dict[str, Any]]
    notes: list[str]


def write_proposal(result: Proposal, out: Path) -> ProposalFile:
    """Write all files, last the page: a page that fails costs no result. Returns what `proposal.json` says.

    Motions that an earlier proposal left, and this one has not, go: nobody is to run them by mistake.
    """
    content, file = to_file(result), out / "proposal.json"
    with last():
        old = _motion_files(file)
        for proposed in result.proposed:
            write_motion(result, proposed.motion, out)
        write_whole(file, content.model_dump_json(indent=1) + "\n")
        remove(out, set(old).difference(f for m in content.motions for f in m.files.values()))
        with spared("the page", result.notes):
            write_page(result, content.model_dump(), out)
    return content


def _motion_files(file: Path) -> list[str]:
    """The files of the motions that a `proposal.json` tells of, if it is one."""
    try:
        content = ProposalFile.model_validate_json(file.read_bytes())
    except (OSError, ValueError):
        return []
    names = [f for m in content.motions for f in m.files.values()]
    return own(file.parent, names, [f"*.{suffix}" for suffix in SUFFIXES.values()])


def to_file(result: Proposal) -> ProposalFile:
    """What `proposal.json` says."""
    names, limits = result.problem.plant.model.joint_names, result.limits
    rows = zip(names, limits.lower, limits.upper, limits.speed, limits.effort, strict=True)
    return ProposalFile(
        scenario=result.problem.file.scenario.name,
        scenario_file=str(result.problem.file.path.absolute()),
        engine=result.problem.engine,
        pose={n: _round(q) for n, q in zip(names, result.home, strict=True)},
        limits={
            n: {
                "lower": _round(a),
                "upper": _round(b),
                "speed": _round(v),
                "effort": _round(e) if e < math.inf else None,
            }
            for n, a, b, v, e in rows
        },
        open=[f"{q} ({now(q)} now)" for q in result.open.questions],
        out_of_reach=[str(q) for q in result.hopeless],
        motions=[_motion(result, p) for p in result.proposed],
        shows=[] if result.shown is None else shows(result.shown),
        notes=list(result.notes),
    )


def _motion(result: Proposal, proposed: Proposed) -> MotionFile:
    motion = proposed.motion
    return MotionFile(
        name=motion.name,
        seconds=_round(motion.seconds),
        segments=[s.label for s in motion.segments],
        condition=motion.condition.label,
        overrides=motion.condition.overrides,
        files={what: f"{motion.name}.{suffix}" for what, suffix in SUFFIXES.items()},
        stays_within_limits_in=list(proposed.engines),
        settles=[_settled(q, a) for q, a in zip(result.open.questions, proposed.answers, strict=True)],
        sharpens=[_sharpened(w) for w in proposed.weak],
        says=settles(result, proposed),
    )


def _settled(question: Question, answer: Answer) -> Settled:
    one, other = question.names
    return Settled(
        one=one,
        other=other,
        now=_round(question.now),
        if_one=_round(answer.one),
        if_other=_round(answer.other),
        same_if=[name for name, alike in zip((one, other), answer.alike, strict=True) if alike],
    )


def _sharpened(weak: Weak) -> Sharpened:
    at = weak.suspect.target
    return Sharpened(
        effect=weak.suspect.effect,
        target=at if isinstance(at, str) else list(at),
        parameter=weak.parameter,
        unit=weak.unit,
        value=_round(weak.value),
        now=_round(weak.now),
        then=_round(weak.then),
        half_after=_round(weak.half) if math.isfinite(weak.half) else None,
    )


def shows(shown: Rehearsal) -> list[dict[str, Any]]:
    """What motions would show of every effect: the smallest size, null where the largest that was tried is not seen."""
    rows = to_json(shown)["detection"]
    return [{k: row[k] for k in ("effect", "target", "seen_from", "largest_tried")} for row in rows]


def seen(shown: Rehearsal) -> list[str]:
    """The same in lines."""
    return [
        f"{label(row)}: " + (f"seen from {words(row['seen_from'])}" if row["seen_from"] else "not seen")
        for row in shows(shown)
    ]


def write_motion(result: Proposal, motion: Excitation, out: Path) -> None:
    """The files of a motion."""
    model = result.problem.plant.model
    text = json.dumps(animation(motion, model), indent=1, ensure_ascii=False)
    write_whole(out / f"{motion.name}.json", text + "\n")
    write_whole(out / f"{motion.name}.csv", _commands(motion, model.joint_names))
    time, value, _ = waypoints(motion)
    write_trajectory(out / f"{motion.name}.mcap", model.joint_names, time, value)
    write_whole(out / f"{motion.name}.yaml", _scenario(result, motion, out))


def _commands(motion: Excitation, joints: Sequence[str]) -> str:
    """The command stream: time [s], every joint's command [rad or m], and whether its servo is on."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["time", *(f"command_{j}" for j in joints), *(f"torque_enabled_{j}" for j in joints)])
    on = np.isfinite(motion.value)
    for t, v, good in zip(motion.time.tolist(), motion.path.tolist(), on.tolist(), strict=True):
        writer.writerow([f"{t:.6f}", *(f"{x:.8g}" for x in v), *(int(g) for g in good)])
    return text.getvalue()


def _scenario(result: Proposal, motion: Excitation, out: Path) -> str:
    """A scenario that plays the motion, and how its recording becomes a run of the one that was diagnosed."""
    raw = rebased(result.problem.file.override(motion.condition.overrides), out)
    for key in ("recordings", "budget", "propose", "accept", "certain", "suspects", "revisions"):
        raw.pop(key, None)
    raw["name"] = motion.name
    raw["motion"] = {"keyframes": f"{motion.name}.json"}
    raw["robot"]["start"] = "keyframe"
    run: dict[str, Any] = {"path": f"{motion.name}_recorded", "use": "train"}
    if motion.condition.overrides:
        run["with"] = motion.condition.overrides
    note = yaml.dump([run], Dumper=Plain, sort_keys=False, allow_unicode=True, width=110)
    head = [
        "plays a proposed motion; once it was recorded, add to recordings.runs of the scenario:",
        *note.splitlines(),
    ]
    body = yaml.dump(raw, Dumper=Plain, sort_keys=False, allow_unicode=True, width=110)
    return "".join(f"# {line}\n" for line in head) + body


def summary(result: Proposal) -> list[str]:
    """Lines for the terminal: each motion with what it will settle, and what no motion can."""
    lines = [f"{p.motion.name}, {p.motion.seconds:.1f} s: {settles(result, p)}" for p in result.proposed]
    lines += [f"  {row}" for row in (seen(result.shown) if result.shown else [])]
    lines += [f"out of reach: {q}: no motion within the limits moves these odds ({now(q)})" for q in result.hopeless]
    return [*lines, *(f"  {note}" for note in result.notes)]


def _round(value: float) -> float:
    return float(f"{value:.6g}")
