"""What a first scenario notes of the recordings it is made of."""

from pathlib import Path

import lerobot_sets
import numpy as np
import pandas as pd
import pytest
from first_scenario import arm, goal
from realitygap.check import check
from realitygap.init.draft import init
from realitygap.scenario.file import load_scenario
from realitygap.simulate.experiment import experiments


def test_rows_that_came_in_no_order_are_told(tmp_path: Path) -> None:
    clock = np.arange(100) * 0.01
    frame = pd.DataFrame({"time": clock, "position": goal(clock), "command": goal(clock)})
    frame = frame.sample(frac=1.0, random_state=1)
    frame.to_csv(tmp_path / "run.csv", index=False)
    draft = init(arm(tmp_path / "arm.urdf", ["elbow"]), [tmp_path / "run.csv"], tmp_path / "out")
    back = (frame["time"].diff() < 0).sum()
    assert draft.told[-1] == f"run: {back} rows came out of order and were sorted"


def test_an_episode_that_holds_the_same_measurement_is_left_out_and_told(tmp_path: Path) -> None:
    folder = lerobot_sets.data_set(tmp_path / "set", "v2.1", tasks=("lift", "lower", "turn"))
    files = [folder / lerobot_sets.LAYOUTS["v2.1"].format(episode_chunk=0, episode_index=k) for k in range(3)]
    pd.read_parquet(files[0]).assign(episode_index=2).to_parquet(files[2])
    draft = init(arm(tmp_path / "arm.urdf", ["elbow", "gripper"]), [folder], tmp_path / "out")
    same = f"{folder}: episode 2: holds the same measurement as {folder}: episode 0, and is left out of the runs"
    assert [line for line in draft.told if "same measurement" in line] == [same]
    assert [case.run.episode for case in load_scenario(draft.path).cases()] == ["lift", "lower"]
    assert len(experiments(load_scenario(draft.path))) == 2


def test_so_is_a_table_of_another_name(tmp_path: Path) -> None:
    clock = np.arange(100) * 0.01
    frame = pd.DataFrame({"time": clock, "position": goal(clock), "command": goal(clock)})
    for name in ("run", "copy"):
        frame.to_csv(tmp_path / f"{name}.csv", index=False)
    files = [tmp_path / "run.csv", tmp_path / "copy.csv"]
    draft = init(arm(tmp_path / "arm.urdf", ["elbow"]), files, tmp_path / "out")
    assert f"{files[1]}: holds the same measurement as {files[0]}, and is left out of the runs" in draft.told
    assert [case.path for case in load_scenario(draft.path).cases()] == files[:1]


def test_a_joint_that_is_only_commanded_is_held_and_told_of_a_table_nearby(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By the draft, and by the check of it."""
    clock = np.arange(100) * 0.01
    frame = pd.DataFrame({"time": clock, "position_shoulder": goal(clock), "command_shoulder": goal(clock)})
    frame.assign(command_elbow=goal(2 * clock)).to_csv(tmp_path / "run.csv", index=False)
    arm(tmp_path / "arm.urdf")
    monkeypatch.chdir(tmp_path)
    draft = init(Path("arm.urdf"), [Path("run.csv")], Path("out"))
    assert draft.told[0].startswith("elbow is held where robot.hold says")
    assert "held_joint" in [m.kind for m in check(load_scenario(draft.path))]
