"""A first scenario of a table: columns by the names that people give them, and a servo for what is commanded."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from first_scenario import EPOCH, STATE, arm, goal, read_all
from realitygap.files.errors import InputError
from realitygap.init.draft import init
from signals import Signals, there


def test_tables_with_other_column_names(tmp_path: Path) -> None:
    time = np.arange(100) * 0.01
    frame = pd.DataFrame({"t": time})
    for joint in ("shoulder", "elbow"):
        frame[f"goal_{joint}"], frame[f"q_{joint}"], frame[f"torque_{joint}"] = goal(time), goal(time - 0.05), 1.0
    frame.to_csv(tmp_path / "run.csv", index=False)
    path = init(arm(tmp_path / "arm.urdf"), [tmp_path / "run.csv"], tmp_path / "out").path
    _, (recording,) = read_all(path, ["shoulder", "elbow"])
    np.testing.assert_allclose(Signals(recording.trace).command[:, 1], goal(time))
    np.testing.assert_allclose(Signals(recording.trace).effort, 1.0)


@pytest.mark.parametrize(
    ("time", "position", "command", "effort"),
    [
        ("time", "pos_meas{n}", "pos_des{n}", "tau_meas{n}"),
        ("t [s]", "q_{n}", "q_cmd_{n}", "tau_{n}"),
        ("timestamp", "actual_q_{z}", "target_q_{z}", "actual_torque_{z}"),
        ("__time", "/joint_states/{j}/position", "/joint_commands/{j}/position", "/joint_states/{j}/effort"),
        ("Time", "{J}Position", "{J}PositionCommand", "{J}Torque"),
        ("stamp", "{j}.angle_rad", "{j}.goal", "{j}.torque_nm"),
        ("time_s", "joint_{n}_position", "joint_{n}_target", "joint_{n}_effort"),
    ],
)
def test_columns_as_people_name_them(time: str, position: str, command: str, effort: str, tmp_path: Path) -> None:
    clock = np.arange(100) * 0.01
    frame = pd.DataFrame({time: clock})
    joints = ("shoulder", "elbow")
    for k, joint in enumerate(joints):
        for form, value in ((command, goal(clock)), (position, goal(clock - 0.05)), (effort, np.sin(clock))):
            frame[form.format(n=k + 1, z=k, j=joint, J=joint.capitalize())] = value + k
        frame[f"temperature_{k}"] = 30.0
    frame.to_csv(tmp_path / "run.csv", index=False)
    draft = init(arm(tmp_path / "arm.urdf", joints), [tmp_path / "run.csv"], tmp_path / "out")
    scenario, (recording,) = read_all(draft.path, joints)
    np.testing.assert_allclose(
        Signals(recording.trace).position, np.column_stack([goal(clock - 0.05) + k for k in (0, 1)])
    )
    np.testing.assert_allclose(Signals(recording.trace).command, np.column_stack([goal(clock) + k for k in (0, 1)]))
    np.testing.assert_allclose(Signals(recording.trace).effort, np.column_stack([np.sin(clock) + k for k in (0, 1)]))
    assert there(scenario.motion).meaning == "position"
    assert draft.told[0] == "not used: temperature_0, temperature_1"


@pytest.mark.parametrize("signals", [("position", "command"), ("effort", "velocity", "position", "command")])
def test_the_columns_of_a_joint_that_is_not_the_robots_are_all_told(signals: tuple[str, ...], tmp_path: Path) -> None:
    clock, joints = np.arange(100) * 0.01, ("shoulder", "elbow")
    frame = pd.DataFrame({"time": clock, "supply_voltage": 12.0})
    for joint in (*joints, "gripper"):
        for signal in signals:
            frame[f"{signal}_{joint}"] = goal(clock)
    frame.to_csv(tmp_path / "run.csv", index=False)
    draft = init(arm(tmp_path / "arm.urdf", joints), [tmp_path / "run.csv"], tmp_path / "out")
    assert draft.told[0] == f"not used: {', '.join(f'{signal}_gripper' for signal in signals)}"


def test_columns_of_all_joints_that_are_not_understood_are_told_with_their_key(tmp_path: Path) -> None:
    """As a scenario writes it: what is told is read so."""
    clock, joints = np.arange(100) * 0.01, ("shoulder", "elbow")
    frame = pd.DataFrame({"time": clock, "weather": 1.0})
    for joint in joints:
        frame[f"{joint}_pos"], frame[f"{joint}_spd"], frame[f"{joint}_tq"] = goal(clock), np.cos(clock), np.sin(clock)
    frame.to_csv(tmp_path / "run.csv", index=False)
    draft = init(arm(tmp_path / "arm.urdf", joints), [tmp_path / "run.csv"], tmp_path / "out")
    (told,) = [line for line in draft.told if line.startswith("not used")]
    assert told == (
        "not used: weather, shoulder_spd, shoulder_tq, elbow_spd, elbow_tq (recordings.columns takes them for all "
        "joints, as `velocity: spd`, and an effort beside it `effort: motor`)"
    )
    text = draft.path.read_text().replace(
        "  columns:\n", "  effort: motor\n  columns:\n    velocity: spd\n    effort: tq\n"
    )
    draft.path.write_text(text)
    trace = Signals(read_all(draft.path, joints)[1][0].trace)
    np.testing.assert_allclose(trace.velocity, np.tile(np.cos(clock)[:, None], 2))
    np.testing.assert_allclose(trace.effort, np.tile(np.sin(clock)[:, None], 2))


@pytest.mark.parametrize(
    ("time", "position", "velocity", "factors"),
    [
        ("timestamp_ms", "q{n} [deg]", "dq{n} [deg/s]", (1e3, 180 / np.pi, 180 / np.pi)),
        ("time_us", "q{n}", "qd{n}_deg", (1e6, 1.0, 180 / np.pi)),
        ("t", "pos{n} (mm)", "vel{n}", (1.0, 1e3, 1.0)),
    ],
)
def test_units_that_columns_name_are_taken(
    time: str, position: str, velocity: str, factors: tuple[float, float, float], tmp_path: Path
) -> None:
    clock, joints = np.arange(100) * 0.01, ("shoulder", "elbow")
    frame = pd.DataFrame({time: clock * factors[0]})
    for n in (1, 2):
        frame[position.format(n=n)] = goal(clock) * factors[1]
        frame[velocity.format(n=n)] = np.gradient(goal(clock), clock) * factors[2]
        frame[f"tau{n}"] = np.sin(clock)
    frame.to_csv(tmp_path / "run.csv", index=False)
    draft = init(arm(tmp_path / "arm.urdf", joints), [tmp_path / "run.csv"], tmp_path / "out")
    scenario, (recording,) = read_all(draft.path, joints)
    assert scenario.follows
    np.testing.assert_allclose(recording.trace.time, clock, atol=1e-12)
    np.testing.assert_allclose(Signals(recording.trace).position[:, 1], goal(clock))
    np.testing.assert_allclose(Signals(recording.trace).velocity[:, 1], np.gradient(goal(clock), clock), atol=1e-12)


@pytest.mark.parametrize(("word", "guessed"), [("command", True), ("goal_position", False), ("target_pos", False)])
def test_that_a_command_is_a_position_is_a_guess_where_its_name_says_nothing(
    word: str, guessed: bool, tmp_path: Path
) -> None:
    """Torques that were asked for are called command, too."""
    clock = np.arange(100) * 0.01
    frame = pd.DataFrame({"time": clock})
    for joint in ("shoulder", "elbow"):
        frame[f"position_{joint}"], frame[f"{word}_{joint}"] = goal(clock), np.cos(9 * clock)
    frame.to_csv(tmp_path / "run.csv", index=False)
    draft = init(arm(tmp_path / "arm.urdf"), [tmp_path / "run.csv"], tmp_path / "out")
    (motion,) = [line for line in draft.path.read_text().splitlines() if line.startswith("motion:")]
    assert ("# GUESS: positions" in motion and "as: effort" in motion) == guessed
    scenario, _ = read_all(draft.path, ["shoulder", "elbow"])
    assert there(scenario.motion).meaning == "position"


@pytest.mark.parametrize(("word", "meaning"), [("torque", "effort"), ("speed", "velocity")])
def test_a_command_that_is_no_position_gets_a_servo_of_its_kind(word: str, meaning: str, tmp_path: Path) -> None:
    clock = np.arange(100) * 0.01
    frame = pd.DataFrame({"time": clock})
    for joint in ("shoulder", "elbow"):
        frame[f"{joint}_pos"], frame[f"{joint}_{word}_command"] = goal(clock), np.cos(clock)
    frame.to_csv(tmp_path / "run.csv", index=False)
    draft = init(arm(tmp_path / "arm.urdf"), [tmp_path / "run.csv"], tmp_path / "out")
    scenario, (recording,) = read_all(draft.path, ["shoulder", "elbow"])
    assert (there(scenario.motion).meaning, [s.kind for s in scenario.servos]) == (meaning, [meaning])
    np.testing.assert_allclose(recording.command, np.tile(np.cos(clock)[:, None], 2))


@pytest.mark.parametrize("meaning", ["effort", "velocity"])
def test_a_topic_that_commands_no_positions_gets_a_servo_of_its_kind(
    meaning: str, tmp_path: Path, write_bag: Callable[..., Path]
) -> None:
    told = []
    for k in range(100):
        stamp = {"stamp": EPOCH + 0.01 * k, "name": ["shoulder", "elbow"]}
        told.append(("/joint_states", EPOCH + 0.01 * k, STATE, {**stamp, "position": [goal(0.01 * k)] * 2}))
        told.append(("/joint_commands", EPOCH + 0.01 * k, STATE, {**stamp, meaning: [0.5, 1.5]}))
    bag = write_bag(tmp_path / "run", "mcap", told)
    scenario, (recording,) = read_all(init(arm(tmp_path / "arm.urdf"), [bag], tmp_path / "out").path, ["shoulder"])
    assert (there(scenario.motion).meaning, [s.kind for s in scenario.servos]) == (meaning, [meaning])
    np.testing.assert_allclose(recording.command, 0.5)


def test_an_effort_that_was_asked_for_and_measured_is_followed_and_both_are_offered(tmp_path: Path) -> None:
    clock = np.arange(100) * 0.01
    frame = pd.DataFrame({"time": clock})
    for joint in ("shoulder", "elbow"):
        frame[f"{joint}_pos"], frame[f"{joint}_torque_command"] = goal(clock), np.cos(clock)
        frame[f"{joint}_current"] = np.sin(clock)
    frame.to_csv(tmp_path / "run.csv", index=False)
    draft = init(arm(tmp_path / "arm.urdf"), [tmp_path / "run.csv"], tmp_path / "out")
    scenario, (recording,) = read_all(draft.path, ["shoulder", "elbow"])
    assert scenario.follows
    np.testing.assert_allclose(Signals(recording.trace).effort, np.tile(np.sin(clock)[:, None], 2))
    assert any("plays back what was asked for" in line for line in draft.told)
    assert not any(line.startswith("not used") for line in draft.told)
    motion = next(line for line in draft.path.read_text().splitlines() if line.startswith("motion:"))
    draft.path.write_text(
        draft.path.read_text().replace(
            motion, 'servos: [{joints: "*", kind: effort}]\nmotion: {recorded: command, as: effort}'
        )
    )
    _, (recording,) = read_all(draft.path, ["shoulder", "elbow"])
    np.testing.assert_allclose(recording.command, np.tile(np.cos(clock)[:, None], 2))


def test_what_is_averaged_as_repetitions_is_told(tmp_path: Path) -> None:
    clock = np.arange(200) * 0.01
    paths: list[Path] = []
    for name, asked in (("free_1", goal(clock)), ("loaded_1", goal(clock)), ("other", goal(1.5 * clock))):
        frame = pd.DataFrame({"time": clock})
        for joint in ("shoulder", "elbow"):
            frame[f"{joint}_command"], frame[f"{joint}_position"] = asked, asked + 1e-3 * len(paths)
        paths.append(tmp_path / f"{name}.csv")
        frame.to_csv(paths[-1], index=False)
    draft = init(arm(tmp_path / "arm.urdf"), paths, tmp_path / "out")
    (told,) = [line for line in draft.told if "repetitions" in line]
    assert told.startswith("taken as repetitions of one motion and averaged: free_1, loaded_1: ")
    assert "`with` at a run says what differs" in told


def named(folder: Path, columns: list[str]) -> Path:
    """A table with a command and a position for every name."""
    clock = np.arange(100) * 0.01
    frame = pd.DataFrame({"time": clock})
    for k, column in enumerate(columns):
        frame[f"{column}_command"], frame[f"{column}_position"] = goal(clock) + k, goal(clock - 0.05) + k
    frame.to_csv(folder / "run.csv", index=False)
    return folder / "run.csv"


def test_a_joint_without_columns_is_held(tmp_path: Path) -> None:
    urdf = arm(tmp_path / "arm.urdf", ("shoulder", "elbow", "wrist"))
    draft = init(urdf, [named(tmp_path, ["shoulder", "elbow"])], tmp_path / "out")
    scenario, _ = read_all(draft.path, ["shoulder", "elbow"])
    assert scenario.robot.hold == {"wrist": 0.0}
    assert any(line.startswith("hold: ") for line in draft.guessed)
    assert not any("may have moved" in line for line in draft.told)
    single = init(urdf, [named(tmp_path, ["elbow"])], tmp_path / "single")
    scenario, (recording,) = read_all(single.path, ["elbow"])
    assert scenario.robot.hold == {"shoulder": 0.0, "wrist": 0.0}
    np.testing.assert_allclose(recording.command[:, 0], goal(np.arange(100) * 0.01))


def test_a_joint_that_is_held_though_it_was_there_is_told(tmp_path: Path) -> None:
    """It may have moved, which the scenario says, too."""
    table = named(tmp_path, ["shoulder", "elbow"])
    pd.read_csv(table).rename(columns={"elbow_position": "elbow_velocity"}).to_csv(table, index=False)
    draft = init(arm(tmp_path / "arm.urdf"), [table], tmp_path / "out")
    assert "may have moved: it has elbow_command, elbow_velocity; add its position" in draft.told[0]
    assert f"  # {draft.told[0]}" in draft.path.read_text().splitlines()


def test_columns_may_leave_out_that_a_joint_is_one(tmp_path: Path) -> None:
    """And are marked as guessed."""
    joints = ("shoulder_joint", "elbow_joint")
    draft = init(arm(tmp_path / "arm.urdf", joints), [named(tmp_path, ["shoulder", "elbow"])], tmp_path / "out")
    _, (recording,) = read_all(draft.path, joints)
    clock = np.arange(100) * 0.01
    np.testing.assert_allclose(recording.command, np.column_stack([goal(clock) + k for k in (0, 1)]))
    np.testing.assert_allclose(
        Signals(recording.trace).position, np.column_stack([goal(clock - 0.05) + k for k in (0, 1)])
    )
    assert any(line.startswith("position: ") and "by their names" in line for line in draft.guessed)


@pytest.mark.parametrize(
    ("joints", "reason"),
    [
        (("shoulder", "elbow"), "by number, in the URDF's order: check it"),
        (("arm2", "arm1"), "by the numbers in the joints' names"),
    ],
)
def test_columns_by_number_are_told_as_such(joints: tuple[str, ...], reason: str, tmp_path: Path) -> None:
    draft = init(arm(tmp_path / "arm.urdf", joints), [named(tmp_path, ["q2", "q1"])], tmp_path / "out")
    (position,) = [line for line in draft.guessed if line.startswith("position: ")]
    assert position.endswith(f"({reason})")


def test_columns_of_other_names_are_told_with_what_to_do(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"recordings.columns.position: \{shoulder: COLUMN\}"):
        init(arm(tmp_path / "arm.urdf"), [named(tmp_path, ["motor_a", "motor_b"])], tmp_path / "out")


EPOCH_NS = 1_700_000_000_990_000_000


@pytest.mark.parametrize("names", [("sec", "nanosec"), ("header.stamp.sec", "header.stamp.nanosec"), ("secs", "nsecs")])
def test_the_two_columns_of_a_stamp_are_one_time(names: tuple[str, str], tmp_path: Path) -> None:
    clock = np.arange(100) * 0.01
    frame = pd.read_csv(named(tmp_path, ["shoulder", "elbow"])).drop(columns="time")
    stamp = EPOCH_NS + np.arange(100) * 10_000_000
    frame.insert(0, names[1], stamp % 10**9)
    frame.insert(0, names[0], stamp // 10**9)
    frame.to_csv(tmp_path / "run.csv", index=False)
    draft = init(arm(tmp_path / "arm.urdf"), [tmp_path / "run.csv"], tmp_path / "out")
    scenario, (recording,) = read_all(draft.path, ["shoulder", "elbow"])
    assert there(scenario.recordings).columns.time == list(names)
    np.testing.assert_allclose(recording.trace.time, clock, atol=1e-9)
    assert any(line.startswith("time: ") for line in draft.guessed)


@pytest.mark.parametrize(("step", "clocks"), [(1, False), (10, True)])
def test_an_index_that_counts_the_rows_is_no_time(step: int, clocks: bool, tmp_path: Path) -> None:
    """As pandas writes one; a column without a name of a time that rises otherwise is one, in ms here."""
    frame = pd.read_csv(named(tmp_path, ["shoulder", "elbow"])).drop(columns="time")
    frame.set_index(frame.index * step).to_csv(tmp_path / "run.csv")
    if clocks:
        draft = init(arm(tmp_path / "arm.urdf"), [tmp_path / "run.csv"], tmp_path / "out")
        assert any("Unnamed: 0 counts in ms" in line for line in draft.guessed)
        return
    with pytest.raises(
        InputError, match=r"has no column of time; .* \(Unnamed: 0 counts the rows\); expected one named"
    ):
        init(arm(tmp_path / "arm.urdf"), [tmp_path / "run.csv"], tmp_path / "out")


TIMES = [(s, u, r) for s in (0.0, 1.7e9) for u in ("s", "ms", "us", "ns") for r in (5.5, 50.0, 500.0)]
TIMES += [(0.0, "s", 4000.0), *((1.7e9, unit, 4000.0) for unit in ("s", "us", "ns"))]
"""Starts, units and rates; at 4 kHz, 250 may be as many µs or ms where nothing is stamped, and ms tell none apart."""


@pytest.mark.parametrize(("start", "unit", "rate"), TIMES)
def test_the_unit_of_a_time_is_guessed_by_its_values(start: float, unit: str, rate: float, tmp_path: Path) -> None:
    """Of those since 1970 for sure; of others as long as a recording is neither slower nor faster than most."""
    frame = pd.read_csv(named(tmp_path, ["shoulder", "elbow"])).drop(columns="time")
    clock = np.arange(100) / rate
    count = np.round((start + clock) * 1e9 / {"s": 1e9, "ms": 1e6, "us": 1e3, "ns": 1.0}[unit], 9 if unit == "s" else 0)
    frame.insert(0, "timestamp", count.astype(np.int64) if unit != "s" else count)
    frame.to_csv(tmp_path / "run.csv", index=False)
    draft = init(arm(tmp_path / "arm.urdf"), [tmp_path / "run.csv"], tmp_path / "out")
    scenario, (recording,) = read_all(draft.path, ["shoulder", "elbow"])
    assert there(scenario.recordings).columns.units.time == unit
    np.testing.assert_allclose(recording.trace.time, clock, atol=2e-3 if unit == "ms" else 1e-6)
    assert any("counts in" in line for line in draft.guessed) == (unit != "s")


@pytest.mark.parametrize("commanded", [True, False])
@pytest.mark.parametrize(("word", "unit"), [("current_mA", "recorded mA"), ("current", "A")])
def test_a_current_is_never_taken_for_an_effort(word: str, unit: str, commanded: bool, tmp_path: Path) -> None:
    """Without its factor it is left out, or where the motion is followed guessed; both are said."""
    path = named(tmp_path, ["shoulder", "elbow"])
    frame = pd.read_csv(path)
    for joint in ("shoulder", "elbow"):
        frame[f"{joint}_{word}"] = np.sin(frame["time"])
    if not commanded:
        frame = frame.drop(columns=["shoulder_command", "elbow_command"])
    frame.to_csv(path, index=False)
    draft = init(arm(tmp_path / "arm.urdf"), [path], tmp_path / "out")
    scenario, (recording,) = read_all(draft.path, ["shoulder", "elbow"])
    effort = there(scenario.recordings).effort
    assert any(f"{word} holds a current" in line and f"N·m per {unit} at the joint" in line for line in draft.told)
    if commanded:
        assert effort == "none"
        assert recording.trace.effort is None
        text = draft.path.read_text()
        assert f"effort: none  # a current: {{measures: motor, factor: FACTOR}} with N·m per {unit} compares it" in text
        draft.path.write_text(text.replace("effort: none", "effort: {measures: motor, factor: 2.5}"))
        _, (recording,) = read_all(draft.path, ["shoulder", "elbow"])
        np.testing.assert_allclose(Signals(recording.trace).effort[:, 0], 2.5 * np.sin(frame["time"]), atol=1e-9)
    else:
        assert scenario.follows
        factor = 1.0 if unit == "A" else 0.001
        np.testing.assert_allclose(Signals(recording.trace).effort[:, 0], factor * np.sin(frame["time"]), atol=1e-9)
        assert any(f"factor: {factor}}} (N·m per {unit} is nowhere stated)" in line for line in draft.guessed)
