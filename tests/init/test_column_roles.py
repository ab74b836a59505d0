"""Which columns of a table a first scenario takes for what, where one word of a name is not all that it says."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from first_scenario import arm, goal, read_all
from realitygap.files.errors import InputError
from realitygap.init.draft import Draft, init
from realitygap.init.names import role_of, words
from signals import Signals, there

CLOCK = np.arange(100) * 0.01
JOINTS = ("shoulder", "elbow")


def drafted(folder: Path, frame: pd.DataFrame, joints: tuple[str, ...] = JOINTS) -> Draft:
    """The first scenario of one table."""
    frame.to_csv(folder / "run.csv", index=False)
    return init(arm(folder / "arm.urdf", joints), [folder / "run.csv"], folder / "out")


@pytest.mark.parametrize("joints", [("elbow",), JOINTS])
@pytest.mark.parametrize("name", ["torque_enabled", "torque_enable"])
def test_a_flag_of_the_torque_is_no_torque(name: str, joints: tuple[str, ...], tmp_path: Path) -> None:
    on = (CLOCK > 0.3).astype(int)
    frame = pd.DataFrame({"time": CLOCK})
    for joint in joints:
        end = f"_{joint}" if len(joints) > 1 else ""
        frame[f"command{end}"], frame[f"position{end}"], frame[f"{name}{end}"] = goal(CLOCK), goal(CLOCK), on
    draft = drafted(tmp_path, frame, joints)
    scenario, (recording,) = read_all(draft.path, joints)
    recordings = there(scenario.recordings)
    assert (recordings.effort, recordings.columns.torque_enabled) == ("none", name)
    assert recording.trace.effort is None
    np.testing.assert_array_equal(np.isnan(Signals(recording.trace).command[:, 0]), on == 0)
    assert not any(line.startswith("not used") for line in draft.told)


@pytest.mark.parametrize("label", ["torque_limit", "position_limit", "torque_mode"])
def test_what_bounds_a_signal_is_none(label: str) -> None:
    assert role_of(words(label)) is None


@pytest.mark.parametrize(
    ("position", "command", "degrees"),
    [
        ("{j} [deg]", "{j}_cmd [deg]", True),
        ("{j}", "{j}_cmd", False),
        ("{j} Ist [°]", "{j} Soll [°]", True),
        ("q{n}", "qdes{n}", False),
        ("q{n}", "q_des{n}", False),
        ("{j}_actpos", "{j}_goalpos", False),
    ],
)
def test_positions_and_commands_by_names_that_say_little(
    position: str, command: str, degrees: bool, tmp_path: Path
) -> None:
    """The joint's name alone beside that of its command, German words, and two words written as one."""
    frame = pd.DataFrame({"time": CLOCK})
    for n, joint in enumerate(JOINTS):
        for form, value in ((position, goal(CLOCK - 0.05) + n), (command, goal(CLOCK) + n)):
            frame[form.format(j=joint, n=n)] = value * (180 / np.pi if degrees else 1.0)
        frame[f"tau{n}" if "{n}" in position else f"{joint} torque [Nm]"] = np.sin(CLOCK)
    draft = drafted(tmp_path, frame)
    scenario, (recording,) = read_all(draft.path, JOINTS)
    assert there(scenario.motion).recorded
    trace = Signals(recording.trace)
    np.testing.assert_allclose(trace.position, np.column_stack([goal(CLOCK - 0.05) + n for n in (0, 1)]))
    np.testing.assert_allclose(trace.command, np.column_stack([goal(CLOCK) + n for n in (0, 1)]))
    np.testing.assert_allclose(trace.effort, np.column_stack([np.sin(CLOCK)] * 2))


def test_a_commanded_velocity_in_one_word_is_one() -> None:
    assert role_of(words("qd_des")) == role_of(words("qddes")) == ("velocity", True, False)
    assert role_of(words("tempsp")) is None
    assert role_of(words("weather")) is None


def test_of_joints_whose_names_stand_alone_the_others_are_held(tmp_path: Path) -> None:
    frame = pd.DataFrame({"time": CLOCK, "shoulder": goal(CLOCK), "shoulder_cmd": goal(CLOCK), "load": 1.0})
    scenario, _ = read_all(drafted(tmp_path, frame).path, ("shoulder",))
    assert scenario.robot.hold == {"elbow": 0.0}


def test_names_that_stand_alone_beside_nothing_say_nothing(tmp_path: Path) -> None:
    """They may be commands."""
    frame = pd.DataFrame({"time": CLOCK, **{joint: goal(CLOCK) for joint in JOINTS}})
    with pytest.raises(InputError, match="no column holds the position of shoulder, elbow"):
        drafted(tmp_path, frame)


def test_where_no_commands_are_found_the_names_that_say_them_are_told(tmp_path: Path) -> None:
    frame = pd.DataFrame({"time": CLOCK})
    for joint in JOINTS:
        frame[f"{joint}_position"], frame[f"{joint}_wanted"] = goal(CLOCK), goal(CLOCK)
    told = drafted(tmp_path, frame).told
    assert any(line.startswith("no column of commands was found") for line in told)
    assert any("one of cmd, command, commanded, des, desired, goal, ref, reference, setpoint, soll" in s for s in told)


@pytest.mark.parametrize(("name", "said"), [(None, "the table's index"), ("stamp", "by its name")])
def test_the_index_of_a_table_is_said_to_be_one(name: str | None, said: str, tmp_path: Path) -> None:
    index = pd.DatetimeIndex(
        pd.Timestamp("2024-03-05 10:00:00", tz="UTC") + pd.to_timedelta(CLOCK, unit="s"), name=name
    )
    frame = pd.DataFrame({f"{joint}_position": goal(CLOCK) for joint in JOINTS}, index=index)
    frame.to_parquet(tmp_path / "run.parquet")
    draft = init(arm(tmp_path / "arm.urdf"), [tmp_path / "run.parquet"], tmp_path / "out")
    (time,) = [line for line in draft.guessed if line.startswith("time: ")]
    assert time == f'time: "{name or "__index_level_0__"}" ({said})'


@pytest.mark.parametrize(
    ("said", "factor"),
    [("torque_mNm", 1e-3), ("tau (mN·m)", 1e-3), ("torque [Ncm]", 1e-2), ("moment N.mm", 1e-3), ("torque_Nm", 1.0)],
)
def test_the_unit_that_an_effort_says_is_its_factor(said: str, factor: float, tmp_path: Path) -> None:
    """A thousand times the effort is a gap of the model, or an effort that its servo can give, too."""
    frame = pd.DataFrame({"time": CLOCK})
    for joint in JOINTS:
        frame[f"{joint}_command"], frame[f"{joint}_position"] = goal(CLOCK), goal(CLOCK - 0.05)
        frame[f"{joint} {said}"] = np.sin(CLOCK) / factor
    draft = drafted(tmp_path, frame)
    _, (recording,) = read_all(draft.path, JOINTS)
    np.testing.assert_allclose(Signals(recording.trace).effort[:, 0], np.sin(CLOCK), atol=1e-9)
    assert any(line.startswith("effort: ") and "as its name says" in line for line in draft.guessed) is (factor != 1.0)


@pytest.mark.parametrize("name", ["torque_enabled", "motors enabled", "servo_enable"])
def test_one_switch_of_all_servos_is_that_of_every_joint(name: str, tmp_path: Path) -> None:
    frame = pd.DataFrame({"time": CLOCK, name: CLOCK < 0.5, "enabled_lamp_2": 1})
    for joint in JOINTS:
        frame[f"{joint}_pos"], frame[f"{joint}_goal"] = goal(CLOCK - 0.05), goal(CLOCK)
    draft = drafted(tmp_path, frame)
    asked = Signals(read_all(draft.path, JOINTS)[1][0].trace).command
    np.testing.assert_allclose(asked[CLOCK < 0.5], np.tile(goal(CLOCK[CLOCK < 0.5])[:, None], 2))
    assert np.isnan(asked[CLOCK >= 0.5]).all()
    assert draft.told[0] == "not used: enabled_lamp_2"


def test_other_positions_of_all_joints_are_told_as_what_may_be_the_commands(tmp_path: Path) -> None:
    """As PlotJuggler writes the points of trajectories; what is told can be written so."""
    points = "/arm_controller/joint_trajectory/points[0]/positions"
    frame = pd.DataFrame({"__time": CLOCK})
    for joint in JOINTS:
        frame[f"/joint_states/position/{joint}"], frame[f"{points}/{joint}"] = goal(CLOCK - 0.05), goal(CLOCK)
    draft = drafted(tmp_path, frame)
    (told,) = [line for line in draft.told if line.startswith("not used")]
    assert told.endswith(f'(where they are what was asked for, `motion: {{recorded: "{points}"}}` takes them)')
    draft.path.write_text(f'{draft.path.read_text()}motion: {{recorded: "{points}"}}\n')
    _, (recording,) = read_all(draft.path, JOINTS)
    np.testing.assert_allclose(recording.command, np.tile(goal(CLOCK)[:, None], 2))
