"""Samples of a trajectory that a scenario holds, in front of a derivative gain: told where spikes are all one sees."""

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from realitygap.check import advice
from realitygap.check.mistake import KINDS
from realitygap.cli.main import main
from realitygap.scenario.file import load_scenario

sys.path.insert(0, str(Path(__file__).parent))  # plain modules, not a package

from teams import Table, generated

TIME = np.arange(600) * 0.005


def told(folder: Path, changes: dict[str, Any], command: np.ndarray | None = None, effort: float = 1.0) -> list[str]:
    """What is said of a servo with a kd that follows a command with some effort [N·m]."""
    team = generated(3, 1, "pid", runs=1)
    asked = np.sin(2.0 * np.pi * TIME) / np.pi if command is None else command
    signals = [x[:, None] for x in (asked, asked, np.gradient(asked, TIME), effort * np.cos(2.0 * np.pi * TIME))]
    team.tables = {"run": Table(TIME, *signals)}
    servo = {"servos.*.kp": 50.0, "servos.*.kd": 0.5}
    return advice(load_scenario(team.write(folder)).override(servo | changes))


def test_spikes_of_a_held_command_are_told(tmp_path: Path) -> None:
    """0.5 N·m·s/rad times up to 10 mrad in two steps of 1 ms are 2.5 N·m: over 5 ms and a sine, 1.12 in the mean."""
    (sentence,) = told(tmp_path, {})
    assert sentence.startswith(
        "run: of commands that are held for 5 ms, kd makes spikes of effort at lift: 1.12 N·m at"
    )
    assert "where 0.707 N·m were measured, and more at a higher step rate; `held: false` in motion takes" in sentence


@pytest.mark.parametrize(
    "changes", [{"motion.held": False}, {"servos.*.kd": 0.0}, {"servos.*.kd": 0.2}, {"physics.step_rate": 200}]
)
def test_without_them_nothing_is_told(changes: dict[str, Any], tmp_path: Path) -> None:
    assert told(tmp_path, changes) == []


def test_efforts_that_are_as_large_may_be_spikes(tmp_path: Path) -> None:
    assert told(tmp_path, {}, effort=9.0) == []


def test_goals_that_change_once_in_a_while_are_no_trajectory(tmp_path: Path) -> None:
    assert told(tmp_path, {}, command=0.2 * np.floor(TIME)) == []


def test_a_check_tells_them_and_no_mistake(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    told(tmp_path, {})
    path = tmp_path / "scenario.yaml"
    path.write_text(path.read_text().replace("kd: ", "kd: 0.5 # ") + "accept: [" + ", ".join(KINDS) + "]\n")
    with pytest.raises(SystemExit) as ended:
        main(["check", str(path)])
    assert not ended.value.code
    assert "note: run: of commands that are held for 5 ms" in capsys.readouterr().out
