"""A first scenario of a gripper whose second finger mimics the first, and was not recorded."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from first_scenario import arm, goal, messages
from lerobot_sets import data_set
from realitygap.check import check
from realitygap.init.draft import Draft, init
from realitygap.scenario.file import load_scenario
from realitygap.simulate.experiment import experiments, simulate
from signals import Signals, there

CLOCK = np.arange(200) * 0.01
JOINTS = ("elbow", "gripper", "finger")


def gripper(path: Path) -> Path:
    """An arm whose last joint follows the one before it, the other way round."""
    text = arm(path, JOINTS).read_text()
    name, _, rest = text.rpartition('<joint name="finger" type="revolute">')
    path.write_text(f'{name}<joint name="finger" type="revolute"><mimic joint="gripper" multiplier="-1"/>{rest}')
    return path


def table(folder: Path, joints: tuple[str, ...]) -> Path:
    frame = pd.DataFrame({"time": CLOCK})
    for joint in joints:
        frame[f"{joint}_command"], frame[f"{joint}_position"] = 0.1 * goal(CLOCK), 0.1 * goal(CLOCK - 0.05)
    frame.to_csv(folder / "run.csv", index=False)
    return folder / "run.csv"


@pytest.mark.parametrize("kind", ["table", "bag", "data set"])
def test_it_follows_and_is_not_held(kind: str, tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    recordings = {
        "table": lambda: table(tmp_path, JOINTS[:2]),
        "bag": lambda: write_bag(tmp_path / "run", "mcap", messages(names=JOINTS[:2])),
        "data set": lambda: data_set(tmp_path / "set"),
    }
    draft = init(gripper(tmp_path / "arm.urdf"), [recordings[kind]()], tmp_path / "out")
    file = load_scenario(draft.path)
    assert not file.scenario.robot.hold
    assert there(file.scenario.recordings).exclude == ["finger"]
    said = "finger was not recorded: it follows gripper, and is simulated and not compared"
    assert said in draft.told
    assert f"  # {said}" in draft.path.read_text().splitlines()
    assert not [mistake.sentence for mistake in check(file) if mistake.kind == "undriven_joint"]
    experiment = experiments(file)[0]
    moved = Signals(simulate(experiment, "mujoco").trace).position
    assert np.ptp(moved[:, 1]) > 0.05
    np.testing.assert_allclose(moved[:, 2], -moved[:, 1], atol=1e-3)


def drafted(folder: Path, joints: tuple[str, ...]) -> Draft:
    return init(gripper(folder / "arm.urdf"), [table(folder, joints)], folder / "out")


def test_where_it_was_measured_it_is_compared(tmp_path: Path) -> None:
    scenario = load_scenario(drafted(tmp_path, JOINTS).path).scenario
    assert not scenario.robot.hold
    assert not there(scenario.recordings).exclude


def test_where_its_leader_is_held_it_is_held_with_it(tmp_path: Path) -> None:
    file = load_scenario(drafted(tmp_path, JOINTS[:1]).path)
    assert file.scenario.robot.hold == {"gripper": 0.0}
    assert not there(file.scenario.recordings).exclude
    assert experiments(file)[0].plant.model.joint_names == ["elbow"]
