"""A joint that is held as it was not measured, and was commanded to move, is told; one that was told to stay is not."""

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from realitygap.check import Mistake, certain, check
from realitygap.scenario.file import load_scenario

sys.path.insert(0, str(Path(__file__).parent))  # plain modules, not a package

from teams import Team, demo


@pytest.fixture(scope="module")
def team() -> Team:
    """Whose elbow is held."""
    out = demo()
    out.scenario["robot"]["hold"] = {"elbow": 0.2}
    return out


def of_held(mistakes: list[Mistake]) -> list[Mistake]:
    return [m for m in mistakes if m.kind == "held_joint"]


def table(team: Team, folder: Path, **names: Any) -> Path:
    """Tables without what was measured of the elbow, and with other names of columns."""
    path = team.write(folder)
    for file in folder.glob("*.csv"):
        frame = pd.read_csv(file)
        measured = [f"{signal}_elbow" for signal in ("position", "velocity", "effort")]
        frame.drop(columns=measured).rename(columns=names).to_csv(file, index=False)
    return path


def test_a_table_that_commands_it_tells_by_how_much(team: Team, tmp_path: Path) -> None:
    path = table(team, tmp_path)
    (found,) = of_held(check(load_scenario(path)))
    worst = found.runs[0]
    asked = team.tables[worst].command[:, 1]
    assert (found.certainty, found.key, len(found.runs)) == ("likely", "robot.hold", len(team.tables))
    assert found.joints == ("elbow",)
    told = f"elbow is welded at 0.2 rad and was commanded from {asked.min():.3g} to {asked.max():.3g} rad: "
    assert found.sentence.startswith(told)
    assert of_held(certain(load_scenario(path))) == [found], "a run says it, too"
    assert of_held(certain(load_scenario(path).override({"accept": ["held_joint"]}))) == []
    assert of_held(certain(load_scenario(path).override({"accept": ["held_joint@elbow"]}))) == []
    assert of_held(certain(load_scenario(path).override({"accept": ["held_joint@shoulder"]}))) == [found]


@pytest.mark.parametrize("motion", ["command_shoulder", "command"])
def test_a_column_that_is_named_with_its_joint_tells_of_the_others(motion: str, team: Team, tmp_path: Path) -> None:
    file = load_scenario(table(team, tmp_path)).override({"motion.recorded": motion})
    assert len(of_held(check(file))) == 1


def test_a_column_without_a_name_is_of_the_joint_that_is_not_held(team: Team, tmp_path: Path) -> None:
    path = table(team, tmp_path, command_shoulder="command", command_elbow="weather")
    assert of_held(check(load_scenario(path))) == []


def test_a_bag_that_commands_it_is_told(team: Team, tmp_path: Path) -> None:
    """Under the recording's own names, and where another held joint is in no command."""
    bags = team.copy()
    for recording in bags.tables.values():
        recording.command_time = recording.time.copy()
    bags.scenario["recordings"]["joints"] = {"*": "left/*"}
    bags.joints = [f"left/{joint}" for joint in bags.joints]
    inertia = 'ixx="1e-4" iyy="1e-4" izz="1e-4" ixy="0" ixz="0" iyz="0"'
    hand = f'<link name="hand"><inertial><mass value="0.1"/><inertia {inertia}/></inertial></link>'
    wrist = '<joint name="wrist" type="continuous"><parent link="forearm"/><child link="hand"/></joint></robot>'
    bags.files = {name: text.replace("</robot>", hand + wrist) for name, text in bags.files.items()}
    bags.scenario["robot"]["hold"] = {"elbow": 0.2, "wrist": 0.0}
    (found,) = of_held(check(load_scenario(bags.write(tmp_path))))
    assert found.sentence.startswith("elbow is welded at 0.2 rad and was commanded from ")
    assert "wrist" not in found.sentence


def test_one_that_is_told_to_stay_where_it_is_held_is_no_mistake(team: Team, tmp_path: Path) -> None:
    still = team.copy()
    for recording in still.tables.values():
        recording.command[:, 1] = 0.2 + 0.05 * np.sin(recording.time)
    assert of_held(check(load_scenario(table(still, tmp_path)))) == []
