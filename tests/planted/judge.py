"""The judge: scores a diagnosis against its sealed truth by the rules of DESIGN.md."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matching import is_right, match, same, spread
from same_law import as_told

SHAPES = ("phase", "static_coefficient", "velocity", "acceleration", "beyond", "rest", "damping")
"""Parameters without a size of their own: their error is not counted."""
OTHER_SHAPES = {
    "effort_limit": ("share",),
    "stribeck_friction": ("exponent",),
    "load_dependent_friction": ("exponent",),
    "effort_hysteresis": ("onset",),
}
UNNAMED = "effort_map"
"""A shape under no law's name: right where what is missing is outside the list."""
VARIABLES = {"position": "angle", "velocity": "speed"}
TURN = 2 * np.pi
VECTORS = {"center_of_mass": ("x", "y", "z"), "base_tilt": ("roll", "pitch"), "payload": ("x", "y", "z")}


@dataclass(frozen=True)
class Score:
    """The score of one case; `None` where a rule does not apply.

    Attributes:
        listed, unlisted: truths among the named effects and all that these cannot be told from, and those that are not.
        fitted, covered: parameters of right names with a 95 % interval, and those whose interval holds the truth.
        besides: wrong names that are true of the machine, but only what keeps its laws nearly right.
        truths, names, names_right: counted at each joint.
        variables_right: outside the list: whether an unnamed effort depends on the right variables.
    """

    case: str
    kind: str
    robot: str
    truth: str
    named: str
    verdict: str
    first_right: bool | None
    exact: bool
    wrong: int
    missed: int
    silent: bool
    parameter_error: float | None
    held_out_before: float | None
    held_out_after: float | None
    gap_removed: float | None
    listed: int
    unlisted: int
    fitted: int
    covered: int
    besides: int
    truths: int
    names: int
    names_right: int
    variables_right: bool | None


def parameter_error(finding: dict[str, Any], truth: dict[str, Any]) -> float | None:
    """Relative error of the parameters that have a size; of a vector, by its length. None for another effect."""
    if finding["effect"] != truth["effect"]:
        return None
    told = {k: float(v["value"]) for k, v in finding["parameters"].items() if v.get("value") is not None}
    true = {k: float(v) for k, v in truth["parameters"].items()}
    vector = VECTORS.get(truth["effect"], ())
    errors = []
    if vector:
        apart = np.array([told.get(k, 0.0) - true.get(k, 0.0) for k in vector])
        errors.append(float(np.linalg.norm(apart) / np.linalg.norm([true.get(k, 0.0) for k in vector])))
    for k in true:
        if k not in vector and not _shape(truth["effect"], k) and true[k] != 0:
            errors.append(abs(told[k] - true[k]) / abs(true[k]) if k in told else float("inf"))
    return float(np.mean(errors)) if errors else None


def _shape(effect: str, parameter: str) -> bool:
    return parameter in SHAPES or parameter in OTHER_SHAPES.get(effect, ())


def coverage(finding: dict[str, Any], truth: dict[str, Any]) -> tuple[int, int]:
    """Fitted parameters of a right name, and those whose interval holds the truth; a shape that is held is not fitted.

    A phase is the same one turn on.
    """
    fitted = covered = 0
    if finding["effect"] != truth["effect"]:
        return 0, 0
    for name, told in finding["parameters"].items():
        if name not in truth["parameters"] or told.get("low") is None or told.get("high") is None:
            continue
        low, high, true = float(told["low"]), float(told["high"]), float(truth["parameters"][name])
        if low == high and (_shape(truth["effect"], name) or name == "periods"):
            continue
        around = [true + k * TURN for k in (-2, -1, 0, 1, 2)] if name == "phase" else [true]
        fitted += 1
        covered += any(low <= x <= high for x in around)
    return fitted, covered


def variables(findings: list[dict[str, Any]], outside: dict[str, Any]) -> bool | None:
    """Whether an unnamed effort was found that depends on what the planted one depends on, and on nothing else."""
    if "variables" not in outside:
        return None
    told = [f.get("variables") or f["parameters"]["variables"] for f in findings if f["effect"] == UNNAMED]
    told = [t["value"] if isinstance(t, dict) else t for t in told]
    return bool(told) and all(sorted(t) == sorted(VARIABLES[v] for v in outside["variables"]) for t in told)


def judge(truth: dict[str, Any], diagnosis: dict[str, Any] | None) -> Score:
    """Score one case; a diagnosis that was not written is `failed`, and right nowhere."""
    joints, truths = truth["joints"], truth["truth"]
    failed = diagnosis is None
    found = [] if diagnosis is None else list(diagnosis["findings"])
    tolerated = [f for f in found if any(same(f, e, t, joints) for e, t in truth["tolerated"])]
    if truth["outside"]:
        tolerated += [f for f in found if f["effect"] == UNNAMED]
    findings = as_told([f for f in found if f not in tolerated], truths)
    at_places, truths_there = spread(findings, joints), spread(truths, joints)
    right = sum(m is not None for m in match(at_places, truths_there, joints))
    if truth["kind"].endswith("several"):
        findings, truths = at_places, truths_there
    matched = match(findings, truths, joints)
    wrong, missed = matched.count(None), len(truths) - sum(m is not None for m in matched)
    errors = [parameter_error(f, truths[m]) for f, m in zip(findings, matched, strict=True) if m is not None]
    held = [coverage(f, truths[m]) for f, m in zip(findings, matched, strict=True) if m is not None]
    words = [n for f in findings for n in (f, *f.get("cannot_tell_from", []))]
    listed = sum(
        any(same(n, t["effect"], t["target"], joints) for n in words)
        or any(same(n, e, place, joints) for n in words for e, place in t["twins"])
        for t in truths
    )
    besides = sum(
        m is None and any(same(f, e, place, joints) for e, place in truth.get("besides", []))
        for f, m in zip(findings, matched, strict=True)
    )
    known = [e for e in errors if e is not None]
    gap = (diagnosis or {}).get("gap", {}).get("held_out") or {}
    before, after = gap.get("before"), gap.get("after")
    removed = None
    if truths and before is not None and after is not None and before > 1.0:
        removed = min((before - after) / (before - 1.0), 1.0)
    first = None
    if truths:
        first = bool(findings) and any(is_right(findings[0], t, joints) for t in truths)
    return Score(
        truth["case"],
        truth["kind"],
        truth["robot"],
        "; ".join(f"{t['effect']} @ {t['target']}" for t in truth["truth"])
        or (truth["outside"]["what"] if truth["outside"] else "nothing"),
        "; ".join(f"{f['effect']} @ {_shown(f['target'])}" for f in found),
        "failed" if diagnosis is None else str(diagnosis["verdict"]),
        first,
        not failed and not wrong and not missed,
        wrong,
        missed,
        not failed and not findings,
        float(np.mean(known)) if known else None,
        before,
        after,
        removed,
        listed,
        len(truths) - listed,
        sum(f for f, _ in held),
        sum(c for _, c in held),
        besides,
        len(truths_there),
        len(at_places),
        right,
        variables(found, truth["outside"] or {}),
    )


def _shown(target: Any) -> str:
    return target if isinstance(target, str) else ", ".join(target)


def read(truth: Path, diagnosis: Path) -> Score:
    """Score the diagnosis in a file against the truth in a file."""
    told = json.loads(truth.read_text())
    return judge(told, json.loads(diagnosis.read_text()) if diagnosis.is_file() else None)
