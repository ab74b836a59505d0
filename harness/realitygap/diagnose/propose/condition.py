"""Conditions: what a motion can be recorded under, another gain, load or supply where the owner has it."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

import numpy as np

from realitygap.diagnose.data.problem import Problem
from realitygap.files.errors import InputError
from realitygap.robot.effects.place import place
from realitygap.robot.plant import Plant, build_plant
from realitygap.scenario.file import ScenarioFile
from realitygap.scenario.propose import ProposeSpec
from realitygap.scenario.schema import Scenario


@dataclass(frozen=True)
class Condition:
    """The `with` of a run, in words, and the scenario and plant that it makes."""

    label: str
    overrides: dict[str, Any]
    scenario: Scenario
    plant: Plant


def conditions(problem: Problem, spec: ProposeSpec) -> list[Condition]:
    """The scenario as it is, as its runs are where they differ from it, and what else the owner has."""
    file = problem.file
    runs = file.scenario.recordings.runs if file.scenario.recordings else []
    wanted: list[tuple[str, dict[str, Any]]] = [("", {})]
    wanted += [(_told(o), o) for o in (*(r.overrides for r in runs), *spec.overrides) if o]
    wanted += [(f"with a load of {mass:g} kg", _load(problem, spec, mass)) for mass in spec.loads if mass > 0.0]
    known = dict[str, Condition]()
    for label, overrides in wanted:
        key = json.dumps(overrides, sort_keys=True)
        if key not in known:
            known[key] = _condition(file, label, overrides)
    return list(known.values())


def _condition(file: ScenarioFile, label: str, overrides: dict[str, Any]) -> Condition:
    own = file.override(overrides)
    try:
        plant = place(build_plant(own), own.scenario.effects)
    except InputError as error:
        raise InputError(f"{file.path}: propose: {error}") from None
    return Condition(label, overrides, own.scenario, plant)


def _told(overrides: dict[str, Any]) -> str:
    return "with " + ", ".join(f"{key} {value}" for key, value in overrides.items())


def _load(problem: Problem, spec: ProposeSpec, mass: float) -> dict[str, Any]:
    links = problem.plant.model.links
    names = [link.name for link in links]
    name = spec.load_at.link or names[-1]
    if name not in names:
        raise InputError(f"{problem.file.path}: propose.load_at.link: found {name}; the robot has {', '.join(names)}")
    at = spec.load_at.place or np.round(links[names.index(name)].com, 6).tolist()
    x, y, z = (float(v) for v in at)
    own = list(problem.file.raw.get("effects") or [])
    return {"effects": [*own, {"effect": "payload", "target": name, "mass": mass, "x": x, "y": y, "z": z}]}
