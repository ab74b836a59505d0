"""The mended model: a scenario and URDFs with the findings in them, which run as they are."""

from __future__ import annotations

import copy
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import yaml

from realitygap.diagnose.data.changes import Change, changed
from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.result.revised_urdf import found_packages, moved_path, revised_urdf
from realitygap.files.whole import write_whole
from realitygap.robot.effects.place import known, place, targets
from realitygap.robot.plant import Plant, build_plant
from realitygap.scenario.file import ScenarioFile, resolve_path

BODY = ("link_mass", "center_of_mass", "link_inertia", "payload")
"""Effects that a URDF says."""
PATHS = ("robot.urdf", "motion.keyframes", "recordings.runs.path", "recordings.dataset.calibration")
MAPPINGS = ("robot.packages.", "revisions.")
"""Keys of a scenario that hold a path, and mappings of paths."""
RUN = "recordings.runs.with."
REVISED, SCENARIO, MJCF = "revised", "scenario.yaml", "robot.mjcf.xml"
"""The folder of the mended model, its scenario, and its file for plain MuJoCo, where one is asked for."""


def write_revised(problem: Problem, changes: Sequence[Change], folder: Path) -> list[Path]:
    """Write `scenario.yaml` and its URDFs into a folder. Returns these files, the scenario first.

    What a URDF can say is put there, into every URDF that a run uses; the other findings stand as effects, in place of
    those that the scenario had there. Where runs differ in what a finding changes (another gain, another load), each
    run says its own value.
    """
    revision = _Revision(problem, changes, folder)
    file, raw = problem.file, rebased(problem.file, folder)
    urdf, effects = revision.of(file)
    raw["robot"]["urdf"] = urdf
    _set_effects(raw, effects)
    for run, original in zip(raw["recordings"]["runs"], file.raw["recordings"]["runs"], strict=True):
        own_urdf, own = revision.of(file.override(original.get("with") or {}))
        overrides = {k: v for k, v in (run.pop("with", None) or {}).items() if k.split(".")[0] != "effects"}
        overrides.pop("robot.urdf", None)
        if own_urdf != urdf or "robot" in overrides:
            overrides["robot.urdf"] = own_urdf
        if own != effects:
            overrides["effects"] = own
        if overrides:
            run["with"] = overrides
    if revision.packages:
        raw["robot"]["packages"] = {**(raw["robot"].get("packages") or {}), **revision.packages}
    path = folder / SCENARIO
    text = yaml.dump(raw, Dumper=Plain, sort_keys=False, allow_unicode=True, width=110)
    write_whole(path, f"# {file.scenario.name} with what the diagnosis found\n{text}")
    return [path, *(folder / name for name in revision.names.values())]


def mended_name(robot: Path) -> str:
    """What the mended file of a scenario's own robot is called; a xacro file is expanded then."""
    return f"robot{'.urdf' if robot.suffix == '.xacro' else robot.suffix}"


class Plain(yaml.SafeDumper):
    """YAML without aliases."""

    def ignore_aliases(self, data: Any) -> bool:
        del data
        return True


class _Revision:
    """Writes the mended URDFs, each once, and says the effects that remain."""

    def __init__(self, problem: Problem, changes: Sequence[Change], folder: Path) -> None:
        self.problem, self.changes, self.folder = problem, changes, folder
        self.touched = {i for c in changes if c.suspect.effect in BODY for i in c.suspect.indices}
        self.names: dict[str, str] = {}
        self.packages: dict[str, str] = {}

    def of(self, file: ScenarioFile) -> tuple[str, list[dict[str, Any]]]:
        """The name of the mended URDF of a scenario, of one run or of all, and the effects beside it."""
        plant = place(build_plant(file), file.scenario.effects)
        return self._urdf(file, plant), [*self._kept(file, plant), *self._found(plant)]

    def _urdf(self, file: ScenarioFile, plant: Plant) -> str:
        robot = file.scenario.robot
        urdf = file.resolve(robot.urdf, "robot.urdf")
        known = {k: file.resolve(v, f"robot.packages.{k}") for k, v in robot.packages.items()}
        for package, where in found_packages(urdf, known).items():
            self.packages[package] = moved_path(where, self.folder)
        mended = changed(plant, self.changes, self.problem.plant).loaded()
        text = revised_urdf(urdf, self.folder, [mended.links[i] for i in sorted(self.touched)], known)
        if text not in self.names:
            taken = self.names.values()
            first = mended_name(urdf)
            stem, suffix = urdf.stem, Path(first).suffix
            others = [f"{stem}{suffix}", *(f"{stem}_{k}{suffix}" for k in range(2, 1000))]
            wanted = [first] if not taken else others
            self.names[text] = next(name for name in wanted if name not in taken)
            write_whole(self.folder / self.names[text], text)
        return self.names[text]

    def _kept(self, file: ScenarioFile, plant: Plant) -> Iterator[dict[str, Any]]:
        """The effects of a scenario that no finding and no URDF replaces."""
        for spec, raw in zip(file.scenario.effects, file.raw.get("effects") or [], strict=True):
            effect = known(spec.effect)
            indices = targets(plant, effect, spec.target)
            gone = set(self.touched) if spec.effect in BODY else set()
            for change in self.changes:
                other = change.suspect.kind
                same = effect.name == other.name and not effect.repeatable
                if same or effect.rules_out(other):
                    gone |= set(change.suspect.indices)
            left = [i for i in indices if i not in gone]
            if left == indices:
                yield copy.deepcopy(raw)
            elif left:
                yield {**copy.deepcopy(raw), "target": _names(plant, effect.sits_at, left)}

    def _found(self, plant: Plant) -> Iterator[dict[str, Any]]:
        """The findings that a URDF cannot say, with the values that they have in this plant."""
        for change in self.changes:
            suspect, effect = change.suspect, change.suspect.kind
            if suspect.effect in BODY:
                continue
            if suspect.table is not None:
                yield {"effect": suspect.effect, "target": suspect.target, **change.spec}
                continue
            mended = changed(plant, [change], self.problem.plant)
            groups: dict[tuple[float, ...], list[int]] = {}
            for i in suspect.indices:
                own = effect.own(mended, i)
                values = {n: own.get(n, v) if effect.parameter(n).absent is None else v for n, v in change.values}
                groups.setdefault(tuple(float(v) for v in values.values()), []).append(i)
            for values_here, indices in groups.items():
                target: Any = suspect.target if isinstance(suspect.target, str) else list(suspect.target)
                if len(groups) > 1:
                    target = _names(plant, effect.sits_at, indices)
                parameters = dict(zip((n for n, _ in change.values), values_here, strict=True))
                yield {"effect": suspect.effect, "target": target, **parameters}


def _names(plant: Plant, sits_at: str, indices: Sequence[int]) -> list[str]:
    names = plant.model.joint_names if sits_at == "joint" else [link.name for link in plant.model.links]
    return [names[i] for i in indices]


def _set_effects(raw: dict[str, Any], effects: list[dict[str, Any]]) -> None:
    raw.pop("effects", None)
    if effects:
        raw["effects"] = effects


def rebased(file: ScenarioFile, folder: Path) -> dict[str, Any]:
    """The raw scenario with its relative paths leading from another folder."""

    def rebase(text: str, key: str) -> str:
        here = resolve_path(file.path.absolute(), text, key)
        there = resolve_path(folder.absolute() / file.path.name, text, key)
        return text if here == there else moved_path(here, folder)  # an absolute path stays as it is written

    def walk(node: Any, key: str) -> Any:
        if isinstance(node, dict):
            return {k: walk(v, f"{key}.{k}" if key else str(k)) for k, v in node.items()}
        if isinstance(node, list):
            return [walk(v, key) for v in node]
        where = key.removeprefix(RUN)
        is_path = where in PATHS or where.startswith(MAPPINGS)
        return rebase(node, key) if is_path and isinstance(node, str) else node

    out: dict[str, Any] = walk(file.raw, "")
    return out
