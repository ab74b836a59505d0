"""A scenario from a program is the scenario of the file that says the same."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from realitygap.files.errors import InputError
from realitygap.robot.effects.library import effects
from realitygap.scenario.file import load_scenario

DEMO = Path(__file__).parents[2] / "scenarios" / "demo"
FILE = DEMO / "scenario.yaml"


def test_a_dict_with_its_folder_is_the_file() -> None:
    told = yaml.safe_load(FILE.read_text(encoding="utf-8"))
    made, read = load_scenario(told, DEMO), load_scenario(FILE)
    assert made.scenario == read.scenario
    assert [(c.name, c.path, c.scenario) for c in made.cases()] == [(c.name, c.path, c.scenario) for c in read.cases()]


def test_a_path_may_be_text_and_a_scenario_is_itself() -> None:
    read = load_scenario(FILE)
    assert load_scenario(str(FILE)) == read
    assert load_scenario(read) is read


def test_without_a_folder_paths_start_where_the_program_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(DEMO)
    file = load_scenario({"name": "a", "robot": {"urdf": "arm.urdf", "base": "fixed"}})
    assert file.existing("arm.urdf", "robot.urdf", "a URDF").samefile(DEMO / "arm.urdf")


def test_what_a_program_has_is_what_a_file_would_say() -> None:
    told = {
        "name": "a",
        "robot": {"urdf": DEMO / "arm.urdf", "base": "fixed", "start": {"elbow": np.float64(0.5)}},
        "physics": {"solver_iterations": np.int64(50)},
        "effects": [effects.coulomb_friction(("elbow", "shoulder"), torque=np.float32(0.5))],
        "recordings": {"runs": [{"path": DEMO / "chirp_1.mcap", "window": (np.float32(1), 2)}]},
    }
    file = load_scenario(told)
    assert yaml.safe_load(yaml.safe_dump(file.raw)) == file.raw, "nothing that a file cannot hold"
    assert file.raw["effects"] == [{"effect": "coulomb_friction", "target": ["elbow", "shoulder"], "torque": 0.5}]
    (case,) = file.cases()
    assert (case.path, case.run.window) == (DEMO / "chirp_1.mcap", (1.0, 2.0))
    assert file.scenario.physics.solver_iterations == 50


def test_a_scenario_does_not_change_with_the_dict_it_came_from() -> None:
    told = {"name": "a", "robot": {"urdf": "arm.urdf", "packages": {"x": "y"}}}
    file = load_scenario(told)
    told["robot"]["packages"]["x"] = "z"  # type: ignore[index]
    assert file.override({}).scenario == file.scenario


def test_an_override_takes_what_a_program_has() -> None:
    file = load_scenario(FILE).override({"effects": [effects.backlash("elbow", angle=np.float64(0.01))]})
    assert file.raw["effects"] == [{"effect": "backlash", "target": "elbow", "angle": 0.01}]


@pytest.mark.parametrize(
    ("told", "sentence"),
    [
        ({"name": "a", "robot": {"urdf": "a.urdf", "bse": "fixed"}}, r"\(scenario\): robot.bse: unknown key"),
        ({"robot": {"urdf": "a.urdf"}}, r"\(scenario\): name: is missing"),
        ({"name": "a", "robot": {"urdf": "a.urdf"}, 1: 2}, r"\(scenario\): .*found the key 1, expected text"),
        ({"name": 3, "robot": {"urdf": "a.urdf"}}, r"\(scenario\): name: found 3; expected text"),
    ],
)
def test_a_dict_that_is_wrong_is_one_sentence(told: dict[str, Any], sentence: str) -> None:
    with pytest.raises(InputError, match=sentence) as caught:
        load_scenario(told)
    assert "\n" not in str(caught.value)


def test_a_dict_that_holds_itself() -> None:
    told: dict[str, object] = {"name": "a"}
    told["robot"] = told
    with pytest.raises(InputError, match="nested too deeply"):
        load_scenario(told)


def test_what_is_no_scenario_at_all() -> None:
    with pytest.raises(TypeError, match="found int; expected the path of a scenario file or a dict"):
        load_scenario(3)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="a folder is for a scenario from a dict"):
        load_scenario(FILE, DEMO)
    with pytest.raises(InputError, match="folder: found 5; expected the path of a folder"):
        load_scenario({"name": "a"}, 5)  # type: ignore[arg-type]


@pytest.mark.parametrize("source", [5, None, [FILE], b"scenario.yaml"])
def test_what_has_no_type_of_a_scenario_is_an_input_error_too(source: Any) -> None:
    with pytest.raises(InputError, match="expected the path of a scenario file or a dict"):
        load_scenario(source)


@pytest.mark.parametrize("changes", [5, {5: 3}, [("ground", "flat")]])
def test_overrides_are_keys_with_values(changes: Any) -> None:
    with pytest.raises(InputError, match="expected a dict of dotted keys and their values"):
        load_scenario(FILE).override(changes)
