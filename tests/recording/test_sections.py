"""A key that is of another kind of recording is refused, with what says the same of the kind that is there."""

from pathlib import Path
from typing import Any

import lerobot_sets
import pandas as pd
import pytest
import yaml
from realitygap.check import check
from realitygap.files.errors import InputError
from realitygap.recording.sections import fitting_cases, unused_keys
from realitygap.scenario.file import ScenarioFile, load_scenario
from realitygap.simulate.experiment import experiments

BAG, TABLE, DATASET = "run.mcap", "run.csv", "set"
DEMO = Path(__file__).parents[2] / "scenarios" / "demo"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """With a bag, a table and a data set."""
    lerobot_sets.data_set(tmp_path / DATASET)
    pd.DataFrame({"time": [0.0, 0.1], "position": [0.0, 1.0]}).to_csv(tmp_path / TABLE, index=False)
    (tmp_path / BAG).write_bytes((DEMO / "steps_1.mcap").read_bytes())
    return tmp_path


def scenario(folder: Path, recordings: dict[str, Any], *runs: str | dict[str, Any]) -> ScenarioFile:
    said = [{"path": run} if isinstance(run, str) else run for run in runs]
    robot = {"urdf": str(DEMO / "arm.urdf"), "base": "fixed"}
    path = folder / "scenario.yaml"
    path.write_text(yaml.safe_dump({"name": "s", "robot": robot, "recordings": {**recordings, "runs": said}}))
    return load_scenario(path)


REFUSED = [
    (BAG, {"columns": {"time": "t"}}, "columns.time: is for tables (CSV, Parquet) and LeRobot data sets; found a bag"),
    (BAG, {"columns": {"units": {"time": "ms"}}}, "columns.units.time: is for tables (CSV, Parquet); found a bag"),
    (BAG, {"dataset": {"units": "degrees"}}, "dataset.units: is for LeRobot data sets; found a bag"),
    (TABLE, {"imu": "/imu"}, "imu: is for bags; found a table"),
    (TABLE, {"dataset": {"units": "degrees"}}, "dataset.units: is for LeRobot data sets; found a table"),
    (DATASET, {"columns": {"units": {"position": "deg"}}}, "columns.units.position: is for tables (CSV, Parquet) and"),
    (DATASET, {"pose": "/pose"}, "pose: is for bags; found a data set"),
]


@pytest.mark.parametrize(("path", "recordings", "said"), REFUSED, ids=[f"{r[0]} {r[2][:20]}" for r in REFUSED])
def test_a_key_of_another_kind_of_recording_is_refused(
    path: str, recordings: dict[str, Any], said: str, folder: Path
) -> None:
    file = scenario(folder, recordings, path)
    for refusing in (fitting_cases, check, experiments):
        with pytest.raises(InputError) as raised:
            refusing(file)
        assert str(raised.value).startswith(f"{file.path}: recordings.{said}")
        assert f", {folder / path}; expected its " in str(raised.value)


@pytest.mark.parametrize(
    ("path", "recordings"),
    [
        (BAG, {"state": "/joint_states", "columns": {"units": {"position": "deg"}}, "battery": "/battery"}),
        (TABLE, {"state": "/joint_states", "columns": {"time": "time", "units": {"time": "ms"}}, "exclude": ["elbow"]}),
        (DATASET, {"columns": {"velocity": "none"}, "dataset": {"units": "radians"}}),
    ],
)
def test_its_own_keys_are_taken(path: str, recordings: dict[str, Any], folder: Path) -> None:
    assert len(fitting_cases(scenario(folder, recordings, path))) == 1


def test_of_recordings_of_several_kinds_each_has_its_keys(folder: Path) -> None:
    said = {"state": "/joint_states", "columns": {"time": "time"}}
    assert len(fitting_cases(scenario(folder, said, BAG, TABLE))) == 2
    own = {"path": BAG, "with": {"recordings.columns.time": "t"}}
    with pytest.raises(InputError, match=r"recordings\.columns\.time: is for tables .* found a bag"):
        fitting_cases(scenario(folder, {"state": "/joint_states"}, own, TABLE))


@pytest.mark.parametrize("state", ["/joint_states", {"topic": "/joint_states", "joints": ["elbow"]}])
@pytest.mark.parametrize(("path", "found"), [(TABLE, "a table"), (DATASET, "a data set")])
def test_a_topic_of_the_state_that_no_recording_takes_is_told(
    path: str, found: str, state: str | dict[str, Any], folder: Path
) -> None:
    file = scenario(folder, {"state": state}, path)
    (said,) = unused_keys(file, fitting_cases(file))
    assert said.startswith(
        f"recordings.state: is for bags, and not used; found {found}, {folder / path}; expected its "
    )


def test_one_that_a_bag_beside_a_table_takes_is_not(folder: Path) -> None:
    for said, runs in (({"state": "/joint_states"}, (BAG, TABLE)), ({}, (TABLE,))):
        file = scenario(folder, said, *runs)
        assert unused_keys(file, fitting_cases(file)) == []
