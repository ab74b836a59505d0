"""The JSON Schemas: what the classes accept they accept, and what a person gets wrong they show."""

import copy
import json
import math
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft202012Validator
from pydantic import TypeAdapter, ValidationError
from realitygap.bench import quantity
from realitygap.cli.json_schema import FILES, json_schema, json_schema_text
from realitygap.cli.main import main
from realitygap.cli.schema_files import SCHEMA_FILES
from realitygap.files.errors import InputError
from realitygap.files.yaml_file import load_yaml
from realitygap.robot.effects import EFFECTS, WRITABLE, Effect
from realitygap.robot.effects.place import place
from realitygap.scenario.file import apply_overrides, load_scenario
from realitygap.simulate.effect_bench import bench

SCENARIOS = Path(__file__).parents[2] / "scenarios"
BUNDLED = sorted(SCENARIOS.glob("*/*.yaml"))
DEMO = load_yaml(SCENARIOS / "demo" / "scenario.yaml")


def kind(told: dict[str, Any]) -> str:
    """Which file it is, by a key that only one has and needs."""
    return "scenario" if "robot" in told else "matrix" if "scenarios" in told else "bench"


def valid(name: str, told: Any) -> bool:
    return bool(Draft202012Validator(json_schema(name)).is_valid(told))


@pytest.mark.parametrize("name", FILES)
def test_those_in_the_package_are_those_of_the_classes(name: str) -> None:
    assert SCHEMA_FILES[name].read_text(encoding="utf-8") == json_schema_text(name), "run `make reference`"
    Draft202012Validator.check_schema(json_schema(name))


@pytest.mark.parametrize("name", FILES)
def test_the_command_prints_them(name: str, capfd: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as end:
        main(["schema", name])
    assert end.value.code == 0
    assert json.loads(capfd.readouterr().out) == json_schema(name)


@pytest.mark.parametrize("path", BUNDLED, ids=lambda p: f"{p.parent.name}/{p.stem}")
def test_every_bundled_file_fits(path: Path) -> None:
    told = load_yaml(path)
    errors = Draft202012Validator(json_schema(kind(told))).iter_errors(told)
    assert [f"{error.json_path}: {error.message}" for error in errors] == []


def test_there_is_one_of_each_kind() -> None:
    assert {kind(load_yaml(path)) for path in BUNDLED} == set(FILES)


WRONG: dict[str, dict[str, Any]] = {
    "unknown key": {"grund": "flat"},
    "unknown key of a section": {"robot.bse": "fixed"},
    "unknown key of a servo": {"servos.drive.gian": 1.0},
    "unknown servo": {"servos.drive.kind": "ac"},
    "text for a number": {"servos.drive.gain": "5"},
    "no number": {"servos.drive.gain": True},
    "out of bounds": {"physics.step_rate": 0},
    "unknown word": {"ground": "mud"},
    "a name of the code": {"motion.meaning": "duty"},
    "unknown effect": {"effects": [{"effect": "friction"}]},
    "parameter missing": {"effects": [{"effect": "coulomb_friction", "target": "elbow"}]},
    "unknown parameter": {"effects": [{"effect": "coulomb_friction", "target": "elbow", "torque": 1.0, "force": 1.0}]},
    "parameter out of bounds": {"effects": [{"effect": "coulomb_friction", "target": "elbow", "torque": -1.0}]},
    "parameter with a unit": {"effects": [{"effect": "coulomb_friction", "target": "elbow", "torque": "0.1 Nm"}]},
}


@pytest.mark.parametrize("name", WRONG)
def test_what_a_scenario_gets_wrong_is_shown(name: str) -> None:
    """`meaning` alone is taken by the classes, too: by its name in the code, which nobody needs to know."""
    told = apply_overrides(SCENARIOS / "demo" / "scenario.yaml", DEMO, WRONG[name])
    assert not valid("scenario", told)
    if name != "a name of the code":
        with pytest.raises(InputError):
            checked(told)


def checked(told: dict[str, Any]) -> None:
    """As a run checks it."""
    place(bench(EFFECTS["coulomb_friction"])[0], load_scenario(told, SCENARIOS / "demo").scenario.effects)


@pytest.mark.parametrize("effect", EFFECTS.values(), ids=list(EFFECTS))
def test_every_effect_has_its_parameters(effect: Effect) -> None:
    told = copy.deepcopy(DEMO)
    size = effect.first_size(*bench(effect))
    spec = {"effect": effect.name, "target": ["a", "b"], **size}
    assert valid("scenario", told | {"effects": [spec]})
    neutral = {p.name: p.absent for p in effect.parameters if p.absent is not None}
    assert valid("scenario", told | {"effects": [spec | neutral]})
    for p in effect.parameters:
        less = {k: v for k, v in spec.items() if k != p.name}
        assert valid("scenario", told | {"effects": [less]}) == (p.default is not None)
        beyond = p.high + 1.0 if p.absent == -math.inf else p.low - 1.0
        assert not valid("scenario", told | {"effects": [spec | {p.name: beyond}]})


@pytest.mark.parametrize("effect", [e for e in WRITABLE.values() if e.example], ids=lambda e: e.name)
def test_an_effect_with_lists_takes_them(effect: Effect) -> None:
    spec = {"effect": effect.name, "target": "elbow", **effect.example}
    assert valid("scenario", DEMO | {"effects": [spec]})
    for name in effect.example:
        assert not valid("scenario", DEMO | {"effects": [{k: v for k, v in spec.items() if k != name}]})


QUANTITIES = {"Torque": "torque", "Speed": "speed", "Voltage": "voltage", "Inertia": "inertia", "Load": "load"}


@pytest.mark.parametrize("name", QUANTITIES)
@pytest.mark.parametrize("form", ["{} {}", "{}  {} ", "{}{}", "{}", "{} furlong"])
def test_a_quantity_is_a_number_and_a_unit(name: str, form: str) -> None:
    adapter = TypeAdapter(getattr(quantity, name))
    spelled = [*quantity.UNITS[QUANTITIES[name]], *(["Nm", "N.m", "N*m"] if name == "Torque" else [])]
    for unit in spelled:
        for number in ("7.3", "1e-3", "2"):
            text = form.format(number, unit)
            fits = bool(Draft202012Validator(adapter.json_schema()).is_valid(text))
            assert fits == form.startswith("{} ") & ("furlong" not in form)
            assert fits == accepts(adapter, text)


def accepts(adapter: TypeAdapter[Any], value: object) -> bool:
    try:
        adapter.validate_python(value)
    except ValidationError:
        return False
    return True
