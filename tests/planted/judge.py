"""The judge: scores a diagnosis against its sealed truth by the rules of DESIGN.md.

A name is right where effect and target are the truth's, where the truth stands among the first three of the named
effect's `cannot_tell_from`, or where the named effect is an exact twin of the truth that stands before it in the table.
"""

import fnmatch
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

LISTED = 3
"""So many of `cannot_tell_from` count."""
SHAPES = ("phase", "exponent", "static_coefficient", "velocity")
"""Parameters without a size of their own: their error is not counted."""
VECTORS = {"center_of_mass": ("x", "y", "z"), "base_tilt": ("roll", "pitch")}


@dataclass(frozen=True)
class Score:
    """The score of one case; `None` where a rule does not apply."""

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


def places(target: Any, joints: list[str]) -> frozenset[str]:
    """What a target means: the joints that its patterns match, or its own name for a link, the base or the ground."""
    patterns = [target] if isinstance(target, str) else [str(x) for x in target]
    matched = [j for j in joints if any(fnmatch.fnmatchcase(j, p) for p in patterns)]
    return frozenset(matched or patterns)


def same(named: dict[str, Any], effect: str, target: Any, joints: list[str]) -> bool:
    """Whether a name is an effect at a target."""
    return named["effect"] == effect and places(named["target"], joints) == places(target, joints)


def is_right(finding: dict[str, Any], truth: dict[str, Any], joints: list[str]) -> bool:
    """Whether a finding counts as the truth."""
    names = [finding, *finding.get("cannot_tell_from", [])[:LISTED]]
    if any(same(n, truth["effect"], truth["target"], joints) for n in names):
        return True
    return any(same(finding, effect, target, joints) for effect, target in truth["twins"])


def match(findings: list[dict[str, Any]], truths: list[dict[str, Any]], joints: list[str]) -> list[int | None]:
    """The truth that each finding stands for, each at most once: plain names before alternatives."""
    out: list[int | None] = [None] * len(findings)
    left = set(range(len(truths)))
    for plain in (True, False):
        for i, finding in enumerate(findings):
            for k in sorted(left) if out[i] is None else []:
                t = truths[k]
                ok = same(finding, t["effect"], t["target"], joints) if plain else is_right(finding, t, joints)
                if ok:
                    out[i] = k
                    left.discard(k)
                    break
    return out


def parameter_error(finding: dict[str, Any], truth: dict[str, Any]) -> float | None:
    """Relative error of the parameters that have a size; of a vector, by its length. None for another effect."""
    if finding["effect"] != truth["effect"]:
        return None
    told = {k: float(v["value"]) for k, v in finding.get("parameters", {}).items()}
    true = {k: float(v) for k, v in truth["parameters"].items()}
    if truth["effect"] in VECTORS:
        names = VECTORS[truth["effect"]]
        apart = np.array([told.get(k, 0.0) - true.get(k, 0.0) for k in names])
        return float(np.linalg.norm(apart) / np.linalg.norm([true.get(k, 0.0) for k in names]))
    names = tuple(k for k in true if k not in SHAPES and true[k] != 0)
    if any(k not in told for k in names):
        return float("inf")
    return float(np.mean([abs(told[k] - true[k]) / abs(true[k]) for k in names])) if names else None


def judge(truth: dict[str, Any], diagnosis: dict[str, Any] | None) -> Score:
    """Score one case; a diagnosis that was not written is `failed`, and right nowhere."""
    joints, truths = truth["joints"], truth["truth"]
    failed = diagnosis is None
    found = [] if diagnosis is None else list(diagnosis["findings"])
    tolerated = [f for f in found if any(same(f, e, t, joints) for e, t in truth["tolerated"])]
    findings = [f for f in found if f not in tolerated]
    matched = match(findings, truths, joints)
    wrong, missed = matched.count(None), len(truths) - sum(m is not None for m in matched)
    errors = [parameter_error(f, truths[m]) for f, m in zip(findings, matched, strict=True) if m is not None]
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
        "; ".join(f"{t['effect']} @ {t['target']}" for t in truths)
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
    )


def _shown(target: Any) -> str:
    return target if isinstance(target, str) else ", ".join(target)


def read(truth: Path, diagnosis: Path) -> Score:
    """Score the diagnosis in a file against the truth in a file."""
    told = json.loads(truth.read_text())
    return judge(told, json.loads(diagnosis.read_text()) if diagnosis.is_file() else None)
