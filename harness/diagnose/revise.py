"""The mended model: a URDF and a scenario with the findings in them, which run as they are."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import defusedxml.ElementTree
import yaml

from engines.model import Model
from harness.diagnose.problem import Change, Problem, changed
from harness.effects import EFFECTS
from harness.results import write_whole
from harness.scenario_file import ScenarioFile

BODY = ("link_mass", "center_of_mass", "link_inertia")
"""Effects that a URDF can say."""


def write_revised(problem: Problem, changes: Sequence[Change], out: Path) -> Path:
    """Write `revised/robot.urdf` and `revised/scenario.yaml` below a result folder.

    The scenario keeps every finding as an effect, which is a total and so may stand in the URDF too; where runs differ
    in what a finding changes, each run says its own value.
    """
    folder = out / "revised"
    file = problem.file
    raw = _rebased(file, folder)
    effects = [_spec(c, c.parameters) for c in changes]
    raw["effects"] = [*(raw.get("effects") or []), *effects]
    for i, run in enumerate((raw.get("recordings") or {}).get("runs") or []):
        case = next((c for c in problem.cases if _is_run(file, i, c.experiment.name)), None)
        if case is None:
            continue
        own = [_spec(c, _own_values(problem, case.experiment.plant, c)) for c in changes]
        if own != effects:
            run["with"] = {**(run.get("with") or {}), "effects": [*(file.raw.get("effects") or []), *own]}
    urdf = file.resolve(file.scenario.robot.urdf, "robot.urdf")
    write_whole(folder / "robot.urdf", _patched(urdf, problem, changes))
    if not any("robot.urdf" in (run.get("with") or {}) for run in (raw.get("recordings") or {}).get("runs") or []):
        raw["robot"]["urdf"] = "robot.urdf"
        body = [e for e in raw["effects"] if e["effect"] in BODY]
        raw["effects"] = [e for e in raw["effects"] if e not in body]
    text = yaml.safe_dump(raw, sort_keys=False, allow_unicode=True, width=110)
    write_whole(folder / "scenario.yaml", f"# {file.scenario.name} with what the diagnosis found\n{text}")
    return folder


def _spec(change: Change, values: Mapping[str, float]) -> dict[str, Any]:
    target = change.suspect.target
    numbers = {n: float(f"{v:.8g}") for n, v in values.items()}
    return {"effect": change.suspect.effect, "target": target if isinstance(target, str) else list(target), **numbers}


def _own_values(problem: Problem, plant: Any, change: Change) -> dict[str, float]:
    """A finding's values in a run whose own values differ from the first run's."""
    effect = EFFECTS[change.suspect.effect]
    mended = changed(plant, [change], problem.plant)
    own = effect.own(mended, change.suspect.indices[0])
    return {n: own.get(n, v) if effect.parameter(n).absent is None else v for n, v in change.values}


def _is_run(file: ScenarioFile, number: int, name: str) -> bool:
    runs = file.scenario.recordings.runs if file.scenario.recordings else []
    return any(case.run is runs[number] or case.run == runs[number] for case in file.cases() if case.name == name)


def _rebased(file: ScenarioFile, folder: Path) -> dict[str, Any]:
    """The raw scenario with its relative paths leading from another folder."""

    def rebase(text: str) -> str:
        if text.startswith(("/", "${", "~")):
            return text
        return Path(os.path.relpath((file.path.parent / text).resolve(), folder.resolve())).as_posix()

    def walk(node: Any, key: str) -> Any:
        if isinstance(node, dict):
            return {k: walk(v, f"{key}.{k}" if key else str(k)) for k, v in node.items()}
        if isinstance(node, list):
            return [walk(v, key) for v in node]
        if isinstance(node, str) and (key in PATHS or key.startswith(("robot.packages.", "revisions."))):
            return rebase(node)
        if isinstance(node, str) and key.endswith((".with.robot.urdf", ".with.motion.keyframes")):
            return rebase(node)
        return node

    out: dict[str, Any] = walk(file.raw, "")
    return out


PATHS = ("robot.urdf", "motion.keyframes", "recordings.runs.path")
"""Keys of a scenario that hold a path."""


def _patched(urdf: Path, problem: Problem, changes: Sequence[Change]) -> str:
    """The URDF's text with masses, centres of mass, inertias and joint friction of the mended model."""
    tree = defusedxml.ElementTree.parse(urdf)
    mended = changed(problem.plant, changes, problem.plant)
    model: Model = mended.model
    touched = {i for c in changes if c.suspect.effect in BODY for i in c.suspect.indices}
    links = {e.get("name"): e for e in tree.getroot().iter("link")}
    for i in sorted(touched):
        link = model.links[i]
        for name in link.merged[1:]:  # what is fixed to the link is part of it now
            inertial = links[name].find("inertial")
            if inertial is not None:
                links[name].remove(inertial)
        _write_inertial(links[link.name], link)
    return _text(tree, urdf)


def _write_inertial(element: Any, link: Any) -> None:
    inertial = element.find("inertial")
    if inertial is None:
        inertial = element.makeelement("inertial", {})
        element.append(inertial)
    for child in list(inertial):
        inertial.remove(child)
    t = link.inertia
    origin = {"xyz": " ".join(repr(float(v)) for v in link.com), "rpy": "0 0 0"}
    names = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
    where = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
    inertia = {n: repr(float(t[ij])) for n, ij in zip(names, where, strict=True)}
    for tag, values in (("origin", origin), ("mass", {"value": repr(float(link.mass))}), ("inertia", inertia)):
        inertial.append(inertial.makeelement(tag, values))


def _text(tree: Any, urdf: Path) -> str:
    import xml.etree.ElementTree as plain

    for mesh in tree.getroot().iter("mesh"):
        name = mesh.get("filename") or ""
        if name and "://" not in name:
            mesh.set("filename", str((urdf.parent / name).resolve()))
    return plain.tostring(tree.getroot(), encoding="unicode") + "\n"
