"""Tables: columns by name, by joint and by mapping; servos that are off; free bodies; and what is wrong with one."""

from pathlib import Path
from typing import Any

import bags
import numpy as np
import pandas as pd
import pyarrow as pa
import pytest
from bags import FILE
from realitygap.files.errors import InputError
from realitygap.recording import read_recording
from realitygap.recording.frames import rotate
from realitygap.recording.readers.table import load
from realitygap.scenario.schema import Scenario
from signals import Signals, there

TIME = np.arange(50) * 0.01


def scenario(
    command: str | None = "command", base: str = "fixed", meaning: str = "position", **recordings: Any
) -> Scenario:
    return bags.scenario(None, command, base, meaning, **recordings)


def one_joint(**more: Any) -> pd.DataFrame:
    return pd.DataFrame({"time": 3.0 + TIME, "command": TIME + 1, "position": TIME, "velocity": 1.0, **more})


def write(frame: pd.DataFrame, path: Path) -> Path:
    frame.to_parquet(path) if path.suffix == ".parquet" else frame.to_csv(path, index=False)
    return path


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_a_single_joint(suffix: str, tmp_path: Path) -> None:
    recording = read_recording(write(one_joint(), tmp_path / f"run{suffix}"), scenario(), ["elbow"], file=FILE)
    np.testing.assert_allclose(recording.trace.time, TIME, atol=1e-12)
    np.testing.assert_array_equal(Signals(recording.trace).position[:, 0], TIME)
    np.testing.assert_array_equal(Signals(recording.trace).command[:, 0], TIME + 1)
    np.testing.assert_array_equal(recording.command_time, recording.trace.time)
    assert recording.command_kind == "position"
    assert recording.trace.supply is None
    assert recording.trace.effort is None


@pytest.mark.parametrize("form", ["{0}_{1}", "{1}_{0}", "{0}.{1}", "{0}/{1}"])
def test_several_joints_by_column_name(form: str, tmp_path: Path) -> None:
    frame = pd.DataFrame({"time": TIME})
    for k, joint in enumerate(("hip", "knee")):
        for signal in ("command", "position"):
            frame[form.format(signal, joint)] = k + TIME
    trace = Signals(read_recording(write(frame, tmp_path / "run.csv"), scenario(), ["knee", "hip"], file=FILE).trace)
    np.testing.assert_allclose(trace.position, np.column_stack([1 + TIME, TIME]))
    np.testing.assert_allclose(trace.command, trace.position)
    assert trace.trace.velocity is None


def test_several_joints_by_mapping(tmp_path: Path) -> None:
    frame = pd.DataFrame({"t": TIME, "x1": TIME, "x2": 2 * TIME, "u1": 0.0, "u2": 1.0})
    columns = {"time": "t", "position": {"a": "x1", "b": "x2"}, "command": {"a": "u1", "b": "u2"}}
    asked = scenario(columns=columns)
    trace = Signals(read_recording(write(frame, tmp_path / "run.csv"), asked, ["b", "a"], file=FILE).trace)
    np.testing.assert_allclose(trace.position, np.column_stack([2 * TIME, TIME]))
    np.testing.assert_allclose(trace.command, np.tile([1.0, 0.0], (50, 1)))
    with pytest.raises(InputError, match=r"columns.position: names no column for joint c; it has a, b"):
        read_recording(tmp_path / "run.csv", asked, ["a", "c"], file=FILE)


def test_a_servo_that_is_off_has_no_command(tmp_path: Path) -> None:
    frame = one_joint(torque_enabled=np.where(TIME < 0.2, 1, 0), supply_voltage=12.0 - TIME)
    recording = read_recording(write(frame, tmp_path / "run.csv"), scenario(), ["elbow"], file=FILE)
    np.testing.assert_array_equal(np.isnan(Signals(recording.trace).command[:, 0]), TIME >= 0.2)
    np.testing.assert_array_equal(np.isnan(recording.command[:, 0]), TIME >= 0.2)
    np.testing.assert_allclose(recording.supply, 12.0 - TIME)


def test_a_temperature_is_of_each_motor_or_of_all_and_may_be_read_more_slowly(tmp_path: Path) -> None:
    two = pd.DataFrame({"time": TIME, "position_a": TIME, "position_b": TIME})
    slow = np.where(np.arange(50) % 10 == 0, 30.0 + TIME, np.nan)
    for more in ({"temperature": slow}, {"temperature_a": slow, "temperature_b": slow}):
        path = write(two.assign(**more), tmp_path / "run.csv")
        trace = read_recording(path, scenario(None), ["a", "b"], file=FILE).trace
        np.testing.assert_allclose(there(trace.temperature)[:40], np.tile(30.0 + TIME[:40, None], (1, 2)))
    asked = scenario(None, columns={"temperature": {"a": "warm", "b": "cold"}})
    path = write(two.assign(warm=40.0, cold=20.0), tmp_path / "named.csv")
    trace = read_recording(path, asked, ["b", "a"], file=FILE).trace
    np.testing.assert_array_equal(there(trace.temperature)[0], [20.0, 40.0])
    with pytest.raises(InputError, match=r"has no column warm, named by recordings.columns.temperature"):
        read_recording(write(two, tmp_path / "none.csv"), asked, ["a", "b"], file=FILE)


def test_effort_in_its_own_column_and_unit(tmp_path: Path) -> None:
    path = write(one_joint(current=0.5), tmp_path / "run.csv")
    asked = scenario(effort={"topic": "current", "factor": 2.0})
    np.testing.assert_allclose(there(read_recording(path, asked, ["elbow"], file=FILE).trace.effort), 1.0)
    with pytest.raises(InputError, match=r"recordings.effort: .*run.csv holds no effort"):
        read_recording(path, scenario(effort="motor"), ["elbow"], file=FILE)


def test_a_command_that_is_a_duty(tmp_path: Path) -> None:
    path = write(one_joint(duty=0.3), tmp_path / "run.csv")
    recording = read_recording(path, scenario("duty", meaning="duty"), ["elbow"], file=FILE)
    assert recording.command_kind == "duty"
    np.testing.assert_allclose(recording.command, 0.3)


@pytest.mark.parametrize("axes", ["body", "world"])
def test_a_free_body_turns_about_world_axes(axes: str, tmp_path: Path) -> None:
    """A body that spins about its own z, which points along the world's -y: a quarter turn about x."""
    angle = 2.0 * TIME
    half = np.sqrt(0.5)
    # rotation about x by +90°, then about the body's z by the angle
    frame = pd.DataFrame({"time": TIME, "x": TIME, "y": 0.0, "z": 1.0})
    frame["qw"], frame["qx"] = half * np.cos(angle / 2), half * np.cos(angle / 2)
    frame["qy"], frame["qz"] = -half * np.sin(angle / 2), half * np.sin(angle / 2)
    spin = np.array([0.0, 0.0, 2.0]) if axes == "body" else np.array([0.0, -2.0, 0.0])
    for name, value in zip(("wx", "wy", "wz"), spin, strict=True):
        frame[name] = value
    asked = scenario(None, "free", columns={"base_angular_axes": axes})
    trace = Signals(read_recording(write(frame, tmp_path / "run.csv"), asked, [], file=FILE).trace)
    assert trace.position.shape == (50, 0)
    assert trace.trace.base_linear is None
    np.testing.assert_allclose(trace.base_angular, np.tile([0.0, -2.0, 0.0], (50, 1)), atol=1e-9)
    # and the orientations do turn like that: the axis stays, the body's x goes round it
    nose = rotate(trace.base_quaternion, np.tile([1.0, 0, 0], (50, 1)))
    np.testing.assert_allclose(np.diff(nose, axis=0) / 0.01, np.cross([0, -2.0, 0], nose)[:-1], atol=0.03)


def test_a_table_without_the_pose_of_a_robot_without_joints_is_told(tmp_path: Path) -> None:
    path = write(one_joint(), tmp_path / "run.csv")
    with pytest.raises(InputError, match=r"no joints that move .*; it has time, .*; expected x, y, z, qw, qx, qy"):
        read_recording(path, scenario(None, "free"), [], file=FILE)


def test_rows_that_repeat_a_time_are_dropped(tmp_path: Path) -> None:
    frame = one_joint()
    frame["time"] = frame["time"].where(frame.index != 10, frame["time"].shift())
    recording = read_recording(write(frame, tmp_path / "run.csv"), scenario(), ["elbow"], file=FILE)
    assert len(recording.trace.time) == 49
    assert Signals(recording.trace).position[9, 0] == TIME[10]
    assert "1 rows repeat the time" in recording.notes[0]


def broken(column: str, row: int, value: object) -> pd.DataFrame:
    frame = one_joint().astype(object)
    changed = pd.Series([value if k == row else old for k, old in enumerate(frame[column])], dtype=object)
    return frame.assign(**{column: changed})


@pytest.mark.parametrize(
    ("frame", "asked", "sentence"),
    [
        (broken("time", 7, 2.0), {}, r"time goes back from 3.06 to 2 s in line 9, expected times that increase"),
        (broken("time", 7, ""), {}, r"time is empty in line 9"),
        (broken("position", 7, "n/k"), {}, r"position is 'n/k' in line 9, expected a number"),
        (broken("position", 7, "inf"), {}, r"position is inf in line 9 \(1 such values\), expected finite numbers"),
        (broken("command", 7, "inf"), {}, r"command is inf in line 9"),
        (
            one_joint(position=np.where(TIME > 0, np.nan, 0.0)),
            {},
            r"49 of 50 samples are without the position of elbow \(49\); expected at least two .*robot.hold",
        ),
        (one_joint().drop(columns="position"), {}, r"has no position of joint elbow; it has the columns time, command"),
        (one_joint().drop(columns="time"), {}, r"has no column time, named by recordings.columns.time; it has command"),
        (one_joint(), {"columns": {"velocity": "speed"}}, r"has no velocity of joint elbow; .*expected speed"),
        (one_joint(), {"battery": "volts"}, r"has no column volts"),
        (one_joint(), {"columns": {"time": ["time"] * 3}}, r"recordings.columns.time: names 3, expected 2"),
        (one_joint(), {"columns": {"time": ["time", "ns"]}}, r"has no column ns, named by recordings.columns.time"),
        (one_joint()[:1], {}, r"holds 1 sample, expected at least two"),
        (one_joint()[:0], {}, r"the table holds no rows; it has the columns time"),
    ],
)
def test_what_is_wrong_with_a_table_is_told(
    frame: pd.DataFrame, asked: dict[str, Any], sentence: str, tmp_path: Path
) -> None:
    path = write(frame, tmp_path / "run.csv")
    with pytest.raises(InputError, match=sentence):
        read_recording(path, scenario(**asked), ["elbow"], file=FILE)


def test_units_are_said_for_all_joints_or_by_pattern(tmp_path: Path) -> None:
    frame = pd.DataFrame(
        {"time": 1e3 * TIME, **{f"{s}_{j}": TIME for s in ("command", "position") for j in ("a", "b")}}
    )
    units = {"time": "ms", "position": {"a": "deg", "*": "mm"}, "command": "deg"}
    path = write(frame, tmp_path / "run.csv")
    recording = read_recording(path, scenario(columns={"units": units}), ["a", "b"], file=FILE)
    np.testing.assert_allclose(recording.trace.time, TIME, atol=1e-12)
    np.testing.assert_allclose(Signals(recording.trace).position, np.outer(TIME, [np.pi / 180, 1e-3]))
    np.testing.assert_allclose(Signals(recording.trace).command, np.outer(TIME, [np.pi / 180] * 2))
    with pytest.raises(InputError, match=r"recordings.columns.units.position: no pattern matches joint b"):
        read_recording(path, scenario(columns={"units": {"position": {"a": "deg"}}}), ["a", "b"], file=FILE)


def test_a_table_without_names_is_told(tmp_path: Path) -> None:
    (tmp_path / "run.csv").write_text("0.0,1.5,-2e-3\n0.01,1.6,2e-3\n")
    with pytest.raises(InputError, match=r"begins with numbers; expected a line with the names"):
        read_recording(tmp_path / "run.csv", scenario(), ["elbow"], file=FILE)


def test_a_command_that_is_not_there(tmp_path: Path) -> None:
    path = write(one_joint().drop(columns="command"), tmp_path / "run.csv")
    with pytest.raises(InputError, match=r"has no command of joint elbow; it has the columns time, position"):
        read_recording(path, scenario("/joint_commands"), ["elbow"], file=FILE)


@pytest.mark.parametrize("columns", [{}, {"command": "command"}])
def test_a_mistyped_command_is_told_and_no_other_column_taken(columns: dict[str, str], tmp_path: Path) -> None:
    path = write(one_joint(), tmp_path / "run.csv")
    said = r"no command of joint elbow; it has the columns time, command, .*expected cmd, .* motion.recorded names cmd"
    with pytest.raises(InputError, match=said):
        read_recording(path, scenario("cmd", columns=columns), ["elbow"], file=FILE)


@pytest.mark.parametrize("recorded", ["command", "/joint_commands"])
def test_the_columns_say_where_a_command_is_that_bags_hold_as_a_topic(recorded: str, tmp_path: Path) -> None:
    path = write(one_joint().rename(columns={"command": "goal"}), tmp_path / "run.csv")
    recording = read_recording(path, scenario(recorded, columns={"command": "goal"}), ["elbow"], file=FILE)
    np.testing.assert_array_equal(recording.command[:, 0], TIME + 1)
    usual = write(one_joint(), tmp_path / "usual.csv")
    recording = read_recording(usual, scenario(recorded), ["elbow"], file=FILE)
    np.testing.assert_array_equal(recording.command[:, 0], TIME + 1)


def rendered(
    frame: pd.DataFrame, separator: str, point: str, *, end: str = "", comment: str = "", header: str | None = None
) -> str:
    """A table as text, as spreadsheets and loggers write it."""
    rows = [separator.join(header or frame.columns) + end]
    rows += [separator.join(repr(float(v)).replace(".", point) for v in row) + end for row in frame.to_numpy()]
    return comment + "\n".join(rows) + "\n"


@pytest.mark.parametrize(
    ("separator", "point", "end", "comment"),
    [
        (",", ".", "", ""),
        (";", ".", "", ""),
        (";", ",", "", ""),
        (";", ",", ";", ""),
        ("\t", ".", "", ""),
        ("\t", ",", "", ""),
        (" ", ".", "", ""),
        ("  ", ",", "", ""),
        (", ", ".", "", "# logged by hand\n# 100 Hz\n"),
        (";", ",", "", "% Messung 7\n"),
        (",", ".", "", "\ufeff"),
    ],
)
def test_the_same_motion_however_a_table_is_written(
    separator: str, point: str, end: str, comment: str, tmp_path: Path
) -> None:
    path = tmp_path / "run.csv"
    path.write_text(rendered(one_joint(), separator, point, end=end, comment=comment), encoding="utf-8")
    trace = Signals(read_recording(path, scenario(), ["elbow"], file=FILE).trace)
    np.testing.assert_allclose(trace.time, TIME, atol=1e-12)
    np.testing.assert_array_equal(trace.position[:, 0], TIME)
    np.testing.assert_array_equal(trace.command[:, 0], TIME + 1)
    np.testing.assert_array_equal(trace.velocity[:, 0], np.ones(50))


@pytest.mark.parametrize("separator", [",", " ", ";"])
def test_a_header_in_a_comment(separator: str, tmp_path: Path) -> None:
    path = tmp_path / "run.csv"
    text = rendered(one_joint(), separator, ".", comment="# by numpy.savetxt\n# ")
    path.write_text(text)
    trace = Signals(read_recording(path, scenario(), ["elbow"], file=FILE).trace)
    np.testing.assert_array_equal(trace.position[:, 0], TIME)
    path.write_text(text.replace("0.07" + separator, "n/k" + separator, 1))
    with pytest.raises(InputError, match=r"(is 'n/k'|n/k).* in line 10, expected a number"):
        read_recording(path, scenario(columns={"position": "position"}), ["elbow"], file=FILE)


def test_a_header_with_a_sign_from_elsewhere(tmp_path: Path) -> None:
    path = tmp_path / "run.csv"
    frame = one_joint().rename(columns={"position": "q [°]"})
    path.write_bytes(rendered(frame, ";", ",").encode("latin-1"))
    asked = scenario(columns={"position": "q [°]"})
    trace = read_recording(path, asked, ["elbow"], file=FILE).trace
    np.testing.assert_array_equal(Signals(trace).position[:, 0], TIME)


PACKERS = {"gz": "gzip", "zst": "zstd"}


def pack(path: Path, suffix: str) -> Path:
    packed = path.with_name(f"{path.name}.{suffix}")
    with pa.output_stream(str(packed), compression=PACKERS[suffix]) as target:
        target.write(path.read_bytes())
    path.unlink()
    return packed


@pytest.mark.parametrize("suffix", PACKERS)
@pytest.mark.parametrize("kind", [".csv", ".tsv", ".parquet"])
def test_a_packed_table_is_the_same_and_one_that_was_cut_off_is_told(suffix: str, kind: str, tmp_path: Path) -> None:
    plain = write(one_joint(), tmp_path / f"run{kind}")
    whole = read_recording(plain, scenario(), ["elbow"], file=FILE).trace
    path = pack(plain, suffix)
    recording = read_recording(path, scenario(), ["elbow"], file=FILE)
    assert recording.name == "run"
    np.testing.assert_array_equal(Signals(recording.trace).position, whole.position)
    data = path.read_bytes()
    for share in (0.0, 0.3, 0.99):
        path.write_bytes(data[: int(share * len(data))])
        with pytest.raises(InputError, match=rf"run{kind}.{suffix}: (cannot be unpacked|is not a table)") as told:
            read_recording(path, scenario(), ["elbow"], file=FILE)
        assert "\n" not in str(told.value)


def test_what_is_packed_in_another_way_is_told(tmp_path: Path) -> None:
    (tmp_path / "run.csv.zip").write_bytes(b"PK")
    with pytest.raises(InputError, match=r"run.csv.zip: is packed in a way that is not read here; expected .gz, .zst"):
        read_recording(tmp_path / "run.csv.zip", scenario(), ["elbow"], file=FILE)


def test_a_damaged_parquet_column_is_told_or_whole(tmp_path: Path) -> None:
    """Bits of its pages' headers: a column may seem to end before the first row."""
    path = tmp_path / "run.parquet"
    pd.DataFrame({"time": 0.01 * np.arange(20)}).to_parquet(path)
    whole, told = path.read_bytes(), set()
    for place in range(4, 400):
        for bit in (0x01, 0x80):
            path.write_bytes(whole[:place] + bytes([whole[place] ^ bit]) + whole[place + 1 :])
            try:
                assert len(load(path)["time"]) == 20
            except InputError as error:
                told.add(str(error).split(": ")[-1])
    assert "it is damaged" in told
