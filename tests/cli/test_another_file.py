"""A file of another kind than the command takes: one sentence with the command that takes it."""

import shutil
from collections.abc import Callable
from itertools import permutations
from pathlib import Path

import pytest
from realitygap.bench.link_file import load_link_bench
from realitygap.bench.servo_file import load_servo_bench
from realitygap.bench.supply_file import load_supply_bench
from realitygap.matrix.matrix_file import load_matrix
from realitygap.scenario.file import load_scenario
from spoiled import DEMO, one_sentence, refused

SCENARIOS = DEMO.parent
OURS = {
    "a scenario": (DEMO / "scenario.yaml", "run"),
    "a matrix": (DEMO / "matrix.yaml", "matrix"),
    "a bench of servos": (SCENARIOS / "bench_servo_mx/bench.yaml", "bench servo"),
    "a bench of a supply": (SCENARIOS / "bench_supply_planted/bench.yaml", "bench supply"),
    "a bench of links": (SCENARIOS / "bench_links_wolfgang/old.yaml", "bench links"),
    "a bench of a ground": (SCENARIOS / "cube_toss/bench.yaml", "bench ground"),
}
COMMANDS = {kind: [command] for kind, (_, command) in OURS.items()}
COMMANDS["a scenario"] += ["check", "diagnose", "rehearse", "audit", "propose"]


@pytest.mark.parametrize(("wanted", "given"), list(permutations(OURS, 2)))
def test_a_command_says_which_other_one_is_meant(
    given: str, wanted: str, tmp_path: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    file, meant = OURS[given]
    shutil.copy(file, tmp_path / "file.yaml")
    for command in COMMANDS[wanted]:
        assert refused(*command.split(), "file.yaml") == 2
        said = one_sentence(capfd.readouterr())
        assert said.startswith(f"realitygap: file.yaml: is {given}, by its key ")
        assert said.endswith(f"{given} is for `realitygap {meant} file.yaml`\n")
    assert [p.name for p in tmp_path.iterdir()] == ["file.yaml"]


def test_a_matrix_whose_scenarios_are_misspelt_is_no_bench(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file.yaml").write_text("name: m\nscenario: scenario.yaml\naxes: {step_rate: [500]}\n")
    assert refused("matrix", "file.yaml") == 2
    assert "did you mean scenarios?" in one_sentence(capfd.readouterr())


@pytest.mark.parametrize("path", sorted(SCENARIOS.glob("*/*.yaml")), ids=lambda p: f"{p.parent.name}/{p.name}")
def test_no_file_of_this_repository_is_taken_for_another(path: Path, data_dir: Path) -> None:
    loaders: list[Callable[[Path], object]] = [load_scenario, load_matrix, load_servo_bench, load_supply_bench,
                                               load_link_bench]  # fmt: skip
    taken = 0
    for load in loaders:
        try:
            load(path)
        except ValueError:
            continue
        taken += 1
    assert taken == (0 if (path.parent.name, path.name) == ("cube_toss", "bench.yaml") else 1)


@pytest.mark.parametrize("command", ["run", "check", "diagnose"])
@pytest.mark.parametrize(("name", "what"), [("arm.urdf", "a robot's file"), ("chirp_1.mcap", "a recording")])
def test_a_robot_or_recording_in_place_of_a_scenario(
    command: str, name: str, what: str, case: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    assert refused(command, case / name) == 2
    said = one_sentence(capfd.readouterr())
    assert f"{name}: is {what}; expected a scenario in YAML: `realitygap init ROBOT RECORDING` writes a first " in said


def test_the_folder_of_a_scenario_in_its_place(case: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert refused("run", case) == 2
    assert f"{case}: is a folder; expected a scenario file, as {case}/scenario.yaml\n" in one_sentence(
        capfd.readouterr()
    )
    (tmp_path / "new").mkdir()
    assert refused("check", tmp_path / "new") == 2
    assert f"which `realitygap init ROBOT RECORDING --out {tmp_path}/new` writes\n" in one_sentence(capfd.readouterr())
