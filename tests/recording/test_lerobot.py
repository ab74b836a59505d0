"""LeRobot data sets in both layouts: the same motion comes out, in radians; what is missing is told in a sentence."""

import json
import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import bags
import numpy as np
import pandas as pd
import pytest
from bags import FILE
from lerobot_sets import COUNT, JOINTS, LAYOUTS, PERIOD, TASKS, data_set, motion, table, write
from realitygap.files.errors import InputError
from realitygap.recording import read_recording
from realitygap.recording.recording import Recording
from realitygap.scenario.file import load_scenario
from realitygap.scenario.schema import Scenario
from realitygap.trace.trace import Trace
from signals import Signals, there


def scenario(episode: int | str | None = 0, command: str | None = "action", **recordings: Any) -> Scenario:
    return bags.scenario(None, command, episode=episode, **recordings)


def read(path: Path, asked: Scenario, joints: Sequence[str] = JOINTS, file: Path = FILE) -> Recording:
    return read_recording(path, asked, joints, file=file)


def close(trace: Trace, episode: int, order: Sequence[int] = (0, 1)) -> None:
    time = np.arange(COUNT) * PERIOD
    np.testing.assert_allclose(trace.time, time, atol=1e-6)
    for value, expected in zip((trace.position, trace.command, trace.velocity), motion(episode), strict=True):
        np.testing.assert_allclose(there(value), expected[:, list(order)], atol=2e-6)


@pytest.mark.parametrize("version", LAYOUTS)
@pytest.mark.parametrize("episode", [0, 1, "lift", "lower"])
def test_both_layouts_give_the_motion_in_radians(version: str, episode: int | str, tmp_path: Path) -> None:
    path = data_set(tmp_path / "set", version)
    recording = read(path, scenario(episode), ("gripper", "elbow"))
    number = episode if isinstance(episode, int) else TASKS.index(episode)
    close(recording.trace, number, order=(1, 0))
    assert recording.source == (path, number)
    assert recording.command_kind == "position"
    assert recording.trace.effort is None


def test_a_set_and_a_table_give_the_same(tmp_path: Path) -> None:
    position, command, velocity = motion(0)
    frame = pd.DataFrame({"time": np.arange(COUNT) * PERIOD})
    for k, joint in enumerate(JOINTS):
        frame[f"position_{joint}"], frame[f"velocity_{joint}"] = position[:, k], velocity[:, k]
        frame[f"command_{joint}"] = command[:, k]
    frame.to_csv(tmp_path / "run.csv", index=False)
    one = read(tmp_path / "run.csv", scenario(None, "command")).trace
    other = read(data_set(tmp_path / "set"), scenario(0)).trace
    for signal in ("time", "position", "velocity", "command"):
        np.testing.assert_allclose(getattr(one, signal), getattr(other, signal), atol=2e-6)


@pytest.mark.parametrize("version", LAYOUTS)
def test_normalized_units_with_a_range(version: str, tmp_path: Path) -> None:
    """-100..100 over the elbow's range, 0..100 over the gripper's: a joint at 0 rad is in the middle of [-1, 1]."""
    path = data_set(tmp_path / "set", version, scale=100.0)
    limits = {"elbow": [-1.0, 1.0], "grip*": [-0.5, 0.5]}
    trace = Signals(read(path, scenario(0, dataset={"units": "normalized", "range": limits})).trace)
    position, _, velocity = motion(0)
    np.testing.assert_allclose(trace.position[:, 0], position[:, 0], atol=2e-6)
    np.testing.assert_allclose(trace.velocity[:, 0], velocity[:, 0], atol=2e-6)
    # 100 units per rad in the file, 100 of them over 1 rad, and 0 at the lower end
    np.testing.assert_allclose(trace.position[:, 1], position[:, 1] - 0.5, atol=2e-6)
    np.testing.assert_allclose(trace.velocity[:, 1], velocity[:, 1], atol=2e-6)


def test_normalized_units_with_a_calibration_file_beside_the_scenario(tmp_path: Path) -> None:
    path = data_set(tmp_path / "set", scale=100.0)
    turn = 4096 / (2 * np.pi)  # counts per rad
    calibration = {"elbow": {"id": 1, "drive_mode": 0, "homing_offset": 7, "range_min": 1000, "range_max": 1000 + turn}}
    (tmp_path / "arm.json").write_text(json.dumps(calibration))
    units = {"elbow": "normalized", "*": "degrees"}
    asked = scenario(0, dataset={"units": units, "calibration": "arm.json"})
    trace = Signals(read(path, asked, file=tmp_path / "scenario.yaml").trace)
    position = motion(0)[0]
    np.testing.assert_allclose(trace.position[:, 0], position[:, 0] / 2, atol=2e-6)  # 200 units over 1 rad
    np.testing.assert_allclose(trace.position[:, 1], np.radians(100 * position[:, 1]), atol=2e-6)


def test_names_of_its_own_and_none_at_all(tmp_path: Path) -> None:
    own = data_set(tmp_path / "own", names="main_{}")
    close(read(own, scenario(0, dataset={"joints": {j: f"main_{j}" for j in JOINTS}})).trace, 0)
    bare = data_set(tmp_path / "bare", names=None)
    close(read(bare, scenario(0, dataset={"joints": {"elbow": "0", "gripper": "1"}})).trace, 0)


def test_a_part_keeps_its_clock_and_the_command_in_force(tmp_path: Path) -> None:
    path = data_set(tmp_path / "set")
    whole = read(path, scenario(0))
    part = read(path, scenario(0, part=[0.205, 0.6]))
    np.testing.assert_array_equal(part.trace.time, whole.trace.time[11:31])
    np.testing.assert_array_equal(Signals(part.trace).position, Signals(whole.trace).position[11:31])
    np.testing.assert_array_equal(Signals(part.trace).command, Signals(whole.trace).command[11:31])
    np.testing.assert_array_equal(part.command, Signals(whole.trace).command[11:31])
    with pytest.raises(InputError, match=r"part \[5, 6\] holds 0 samples of .*set, which lasts from 0.00 to 1.18 s"):
        read(path, scenario(0, part=[5, 6]))


def test_every_run_is_an_episode_with_a_name_of_its_own(tmp_path: Path) -> None:
    data_set(tmp_path / "set")
    runs = [{"path": "set", "episode": "lift"}, {"path": "set", "episode": 1, "part": [0.11, 0.51]}]
    raw = {"name": "a", "robot": {"urdf": "a.urdf", "base": "fixed"}, "motion": {"recorded": "action"}}
    file = tmp_path / "scenario.yaml"
    file.write_text(json.dumps({**raw, "recordings": {"runs": runs}}))
    cases = load_scenario(file).cases()
    assert [case.name for case in cases] == ["lift", "set_1"]
    found = [read(case.path, case.scenario, file=file) for case in cases]
    assert [len(r.trace.time) for r in found] == [COUNT, 20]
    file.write_text(json.dumps({**raw, "recordings": {"runs": [runs[0], runs[0]]}}))
    with pytest.raises(InputError, match=r"runs\[1\]: .*set stands twice"):
        load_scenario(file).cases()


@pytest.mark.parametrize(
    ("asked", "sentence"),
    [
        (scenario(None), r"recordings: episode: is missing; .*set has 2 episodes; .*0 \(lift\), 1 \(lower\)"),
        (scenario(7), r"has no episode 7; it has 0 \(lift\), 1 \(lower\)"),
        (scenario("lifts"), r"has no episode 'lifts'; .*did you mean lift\?"),
        (scenario(command="actions"), r"motion.recorded: .*set has no feature actions; it has observation.state, a"),
        (scenario(effort="motor"), r"recordings.columns.effort: .*has no feature observation.effort"),
        (scenario(columns={"position": "state"}), r"recordings.columns.position: .*has no feature state"),
        (scenario(dataset={"joints": {"elbow": "e"}}), r"observation.state of .*set has no joint e; it has elbow, gr"),
        (scenario(dataset={"units": "normalized"}), r"joint elbow is in normalized units; expected calibration: FILE"),
        (scenario(dataset={"units": {"e*": "radians"}}), r"dataset.units: no pattern matches joint gripper"),
        (scenario(dataset={"units": "percent", "calibration": "no.json"}), r"no.json: cannot be read .*No such file"),
    ],
)  # fmt: skip
def test_what_does_not_fit_is_told(asked: Scenario, sentence: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=sentence):
        read(data_set(tmp_path / "set"), asked)


def test_a_task_of_several_episodes_is_no_name(tmp_path: Path) -> None:
    path = data_set(tmp_path / "set", tasks=("lift", "lift", "lower"))
    with pytest.raises(InputError, match=r"'lift' is the task of 2 episodes .*expected one of the numbers 0, 1"):
        read(path, scenario("lift"))
    close(read(path, scenario("lower")).trace, 2)


@pytest.mark.parametrize("share", [0.0, 0.3, 0.9, 0.999])
@pytest.mark.parametrize("version", LAYOUTS)
def test_a_set_that_was_cut_off(version: str, share: float, tmp_path: Path) -> None:
    path = data_set(tmp_path / "set", version)
    passed_over = ("tasks.parquet", "tasks.jsonl", "episode_000000.parquet")
    for file in [f for f in path.rglob("*") if f.is_file() and f.name not in passed_over]:
        whole = file.read_bytes()
        file.write_bytes(whole[: int(share * len(whole))])
        with pytest.raises(InputError, match=rf"{file.name}: |has no episode|has no episodes") as told:
            read(path, scenario(1))
        assert "\n" not in str(told.value)
        file.write_bytes(whole)
    close(read(path, scenario(1)).trace, 1)


@pytest.mark.parametrize("version", LAYOUTS)
def test_what_is_missing_of_a_set_is_told(version: str, tmp_path: Path) -> None:
    path = data_set(tmp_path / "set", version)
    file = min((path / "data").rglob("*.parquet"))
    whole = file.read_bytes()
    file.write_text("version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 1\n")
    with pytest.raises(InputError, match="is a pointer of git-lfs, not the data"):
        read(path, scenario(0))
    file.write_bytes(whole)
    table(pd.read_parquet(file)[:30], file)
    with pytest.raises(InputError, match=r"holds 30 rows of episode 0, expected 60 as in meta/"):
        read(path, scenario(0))
    shutil.rmtree(path / "data")
    with pytest.raises(InputError, match=r"parquet: is missing; expected the rows"):
        read(path, scenario(0))
    info = json.loads((path / "meta/info.json").read_text())
    write(path / "meta/info.json", json.dumps(info | {"codebase_version": "v1.6"}))
    with pytest.raises(InputError, match=r"codebase_version: found v1.6, expected v2.0, v2.1 or v3.0"):
        read(path, scenario(0))
    del info["features"]
    write(path / "meta/info.json", json.dumps(info))
    with pytest.raises(InputError, match=r"is not the description of a LeRobot .* \('features' is missing\)"):
        read(path, scenario(0))


@pytest.mark.parametrize(
    "part", ["meta", "meta/info.json", "data", "data/chunk-000", "data/chunk-000/file-000.parquet"]
)
def test_a_part_of_a_set_is_told_with_the_set(part: str, tmp_path: Path) -> None:
    path = data_set(tmp_path / "set")
    with pytest.raises(InputError, match=rf"{part}: is a part of the LeRobot data set {path}; expected the data set's"):
        read(path / part, scenario())


def test_a_table_beside_a_set_is_none_of_its_parts(tmp_path: Path) -> None:
    path = data_set(tmp_path / "set")
    pd.DataFrame({"time": [0.0, 0.1], "position": [0.0, 0.1]}).to_csv(path / "run.csv", index=False)
    trace = read(path / "run.csv", scenario(None, None), ["elbow"]).trace
    np.testing.assert_allclose(Signals(trace).position[:, 0], [0.0, 0.1])
