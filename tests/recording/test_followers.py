"""A joint that mimics another and was not recorded: what the other one tells of it, and nothing else."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from realitygap.files.errors import InputError
from realitygap.recording import Recording, read_recording
from realitygap.scenario.schema import Scenario
from realitygap_engines.model.robot import Mimic
from signals import Signals

CLOCK = np.arange(100) * 0.01
JOINTS = ("lead", "follower", "other")
MIMICS = {"follower": Mimic("lead", -2.0, 0.1)}
FILE = Path("scenario.yaml")


def read(folder: Path, *, meaning: str = "position", lacking: tuple[str, ...] = ("follower",)) -> Recording:
    """The recording of a table in which some joints are not."""
    frame = pd.DataFrame({"time": CLOCK})
    for k, joint in enumerate(j for j in JOINTS if j not in lacking):
        for i, signal in enumerate(("command", "position", "velocity", "effort")):
            frame[f"{joint}_{signal}"] = np.sin(CLOCK + i) + k
    frame.to_csv(folder / "run.csv", index=False)
    asked = {"name": "gripper", "robot": {"urdf": "arm.urdf"}, "recordings": {"effort": "motor"}}
    scenario = Scenario.model_validate({**asked, "motion": {"recorded": "command", "as": meaning}})
    return read_recording(folder / "run.csv", scenario, JOINTS, file=FILE, mimics=MIMICS)


def test_it_is_where_its_leader_puts_it(tmp_path: Path) -> None:
    recording = read(tmp_path)
    trace = Signals(recording.trace)
    assert recording.trace.joints == JOINTS
    np.testing.assert_allclose(trace.position[:, 1], -2.0 * np.sin(CLOCK + 1) + 0.1)
    np.testing.assert_allclose(trace.velocity[:, 1], -2.0 * np.sin(CLOCK + 2))
    np.testing.assert_allclose(recording.command[:, 1], -2.0 * np.sin(CLOCK) + 0.1)
    assert np.isnan(trace.effort[:, 1]).all()
    np.testing.assert_allclose(trace.position[:, 2], np.sin(CLOCK + 1) + 1)
    assert any("follower is taken to follow lead" in note for note in recording.notes)


@pytest.mark.parametrize(
    ("meaning", "expected"), [("velocity", -2.0 * np.sin(CLOCK)), ("effort", np.full(len(CLOCK), np.nan))]
)
def test_its_command_is_what_the_leaders_makes_of_it(meaning: str, expected: np.ndarray, tmp_path: Path) -> None:
    np.testing.assert_allclose(read(tmp_path, meaning=meaning).command[:, 1], expected)


def test_what_was_measured_of_it_counts(tmp_path: Path) -> None:
    recording = read(tmp_path, lacking=())
    np.testing.assert_allclose(Signals(recording.trace).position[:, 1], np.sin(CLOCK + 1) + 1)
    assert not any("follow" in note for note in recording.notes)


@pytest.mark.parametrize("lacking", [("lead",), ("other",), ("follower", "other")])
def test_a_joint_that_is_free_has_to_be_recorded(lacking: tuple[str, ...], tmp_path: Path) -> None:
    missing = next(joint for joint in JOINTS if joint in lacking)
    with pytest.raises(InputError, match=rf"has no position of joint {missing}; it has the columns time, "):
        read(tmp_path, lacking=lacking)
