"""Recordings with other names for the robot's joints: told by the scenario, they are read; untold, what to write is."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from bags import EPOCH, FILE, FORMS, scenario, two_joints
from lerobot_sets import data_set
from realitygap.files.errors import InputError
from realitygap.recording import read_recording
from realitygap.scenario.joint_names import name_patterns
from realitygap.scenario.schema import Motion
from signals import Signals

PREFIXED = {"a": "left_arm/a", "b": "left_arm/b"}
FOUND = 'it has left_arm/a, left_arm/b; expected names as in the URDF, or recordings.joints: {"*": "left_arm/*"}'
MAPPINGS = [{"*": "left_arm/*"}, PREFIXED, {"a": "left_arm/a", "?": "left_arm/*"}]


def prefixed(names: dict[str, str] = PREFIXED) -> list[tuple[str, float, str, dict[str, Any]]]:
    return [(t, at, kind, {**m, "name": [names[n] for n in m["name"]]}) for t, at, kind, m in two_joints()]


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("mapping", MAPPINGS)
def test_a_bag_is_read_as_if_it_had_the_robots_names(
    mapping: dict[str, str], form: str, tmp_path: Path, write_bag: Callable[..., Path]
) -> None:
    suffix = ".bag" if form == "bag" else ""
    own = write_bag(tmp_path / f"own{suffix}", form, two_joints())
    other = write_bag(tmp_path / f"other{suffix}", form, prefixed())
    expected = Signals(read_recording(own, scenario(), ["a", "b"], file=FILE).trace)
    found = Signals(read_recording(other, scenario(joints=mapping), ["a", "b"], file=FILE).trace)
    assert found.trace.joints == ("a", "b")
    for signal in ("position", "velocity", "command"):
        np.testing.assert_array_equal(getattr(found, signal), getattr(expected, signal))


def test_trajectories_and_arrays_are_read_so_too(tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    """The order of an array is told in the robot's own names, as it stands in the scenario."""
    points = [{"positions": [7.0, 8.0], "time_from_start": {"sec": 0, "nanosec": 500_000_000}}]
    goal = {"stamp": EPOCH, "joint_names": ["left_arm/b", "left_arm/a"], "points": points}
    messages = [m for m in prefixed() if m[0] == "/joint_states"]
    messages.append(("/goal", EPOCH, "trajectory_msgs/msg/JointTrajectory", goal))
    messages.append(("/array", EPOCH, "std_msgs/msg/Float64MultiArray", {"data": [5.0, 6.0]}))
    path = write_bag(tmp_path / "run", "mcap", messages)
    asked = scenario(command="/goal", joints={"*": "left_arm/*"})
    trace = Signals(read_recording(path, asked, ["a", "b"], file=FILE).trace)
    np.testing.assert_allclose(trace.command[-1], [8.0, 7.0])
    asked = asked.model_copy(update={"motion": Motion(recorded="/array", joints=["b", "a"])})
    trace = Signals(read_recording(path, asked, ["a", "b"], file=FILE).trace)
    np.testing.assert_allclose(trace.command[-1], [6.0, 5.0])


def test_a_table_is_read_so_too(tmp_path: Path) -> None:
    time = np.arange(10) * 0.01
    pd.DataFrame({"time": time, "position_j1": time, "j2_position": 2 * time}).to_csv(tmp_path / "run.csv", index=False)
    asked = scenario(None, None, joints={"a": "j1", "b": "j2"})
    trace = read_recording(tmp_path / "run.csv", asked, ["a", "b"], file=FILE).trace
    np.testing.assert_allclose(Signals(trace).position, np.column_stack([time, 2 * time]))
    asked = scenario(None, None, joints={"a": "j1", "b": "j3"})
    with pytest.raises(InputError, match=r"has no position of joint b; .*expected position_j3, "):
        read_recording(tmp_path / "run.csv", asked, ["a", "b"], file=FILE)


@pytest.mark.parametrize(
    ("names", "mapping", "sentence"),
    [
        (PREFIXED, {}, f"/joint_states: has no joint a, b; {FOUND}"),
        (PREFIXED, {"*": "right/*"}, f"no joint right/a, right/b; {FOUND}"),
        ({"a": "j1", "b": "j2"}, {}, "it has j1, j2; expected names as in the URDF, or recordings.joints: {a: ITS "),
        (
            {"a": "a", "b": "j2"},
            {},
            "has no joint b; it has j2, a; expected all: a joint that was not recorded is welded by robot.hold, and "
            "recordings.joints tells its name here",
        ),
        (PREFIXED, {"knee": "left_arm/a"}, f"{FILE}: recordings.joints: knee matches no joint; the robot has a, b"),
        (PREFIXED, {"*": "left_arm"}, "recordings.joints: gives a and b the same name left_arm; expected another "),
        (PREFIXED, {"a": "b"}, "recordings.joints: gives a and b the same name b"),
    ],
)
def test_what_does_not_fit_says_what_to_write(
    names: dict[str, str], mapping: dict[str, str], sentence: str, tmp_path: Path, write_bag: Callable[..., Path]
) -> None:
    path = write_bag(tmp_path / "run", "mcap", prefixed(names))
    with pytest.raises(InputError, match=re.escape(sentence)):
        read_recording(path, scenario(joints=mapping), ["a", "b"], file=FILE)


def test_a_data_set_has_its_own_key(tmp_path: Path) -> None:
    asked = scenario(None, "action", episode=0, joints={"elbow": "j1"})
    with pytest.raises(InputError, match=r"recordings.joints: are names of bags and tables; expected dataset: {joints"):
        read_recording(data_set(tmp_path / "set"), asked, ["elbow"], file=FILE)


@pytest.mark.parametrize(
    ("found", "joints", "expected"),
    [
        ({"robot1_shoulder", "robot1_elbow", "robot1_gripper"}, ["shoulder", "elbow"], ["robot1_*"]),
        ({"l/hip", "l/knee", "r/hip", "r/knee"}, ["hip", "knee"], ["l/*", "r/*"]),
        ({"hip_left", "knee_left"}, ["hip", "knee"], ["*_left"]),
        ({"left_j1", "left_j11"}, ["j1"], ["left_*", "left_*1"]),
        ({"left_j1", "left_j11"}, ["j1", "j11"], ["left_*"]),
        ({"l/hip", "r/knee"}, ["hip", "knee"], []),
        ({"hip", "knee"}, ["hip", "knee"], []),
        (set(), ["hip"], []),
        ({"hip"}, [], []),
    ],
)
def test_names_that_all_joints_share(found: set[str], joints: list[str], expected: list[str]) -> None:
    assert name_patterns(found, joints) == expected
