"""What stands in a bag is what comes out, whatever its format, and a bag that is no good says why in one sentence."""

import shutil
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest
from bags import EPOCH, FILE, FORMS, scenario, two_joints
from realitygap.files.errors import InputError
from realitygap.recording import read_recording
from realitygap.recording.readers.rosbag import opened
from realitygap.scenario.schema import Scenario
from rosbags.rosbag2 import StoragePlugin, Writer
from signals import Signals


@pytest.mark.parametrize("bare", [False, True])
@pytest.mark.parametrize("form", FORMS)
def test_every_format_gives_the_same(form: str, bare: bool, tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    path = write_bag(tmp_path / "run.bag" if form == "bag" else tmp_path / "run", form, two_joints())
    if bare and form != "bag":
        path = next(path.glob(f"*.{form}"))
    recording = read_recording(path, scenario(), ["a", "b"], file=FILE)
    trace = Signals(recording.trace)
    time = np.arange(100) * 0.01
    assert trace.joints == ("a", "b")
    assert recording.name == "run"
    np.testing.assert_allclose(trace.time, time, atol=1e-6)
    np.testing.assert_allclose(trace.position, np.column_stack([time, 2 * time]), atol=1e-6)
    np.testing.assert_allclose(trace.velocity, np.tile([1.0, 2.0], (100, 1)))
    assert trace.trace.effort is None
    # held between commands; the first one, 5 ms after the first state, holds before it too
    held = np.maximum(time - 0.005, 0.005)
    np.testing.assert_allclose(trace.command, np.column_stack([10 + held, 20 + held]), atol=1e-6)
    np.testing.assert_allclose(recording.command_time[1:], time + 0.005, atol=1e-6)


def test_a_folder_without_metadata_is_its_one_file(tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    path = write_bag(tmp_path / "run", "mcap", two_joints())
    (path / "metadata.yaml").unlink()
    assert len(read_recording(path, scenario(), ["a"], file=FILE).trace.time) == 100


@pytest.mark.parametrize("form", FORMS)
def test_any_message_whose_definition_is_in_the_bag(form: str, tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    kind = "team_msgs/msg/Servos"
    text = "std_msgs/Header header\nstring[] servos\nfloat32[] radians\nteam_msgs/Load load\n"
    definitions = {"team_msgs/msg/Load": "float64[] newton_metres\n", kind: text}
    messages = []
    for k in range(20):
        values = {"servos": ["b", "a"], "radians": [k, 2 * k], "load": {"newton_metres": [3.0, 4.0]}}
        messages.append(("/servos", EPOCH + 0.01 * k, kind, {"stamp": EPOCH + 0.01 * k, **values}))
    stream = {"topic": "/servos", "names": "servos", "position": "radians", "effort": "load.newton_metres"}
    path = write_bag(tmp_path / ("run.bag" if form == "bag" else "run"), form, messages, definitions)
    trace = Signals(read_recording(path, scenario(stream, None, effort="joint"), ["a", "b"], file=FILE).trace)
    np.testing.assert_allclose(trace.position[:, 0], 2 * np.arange(20))
    np.testing.assert_allclose(trace.effort, np.tile([4.0, 3.0], (20, 1)))
    wrong = {**stream, "position": "degrees"}
    with pytest.raises(InputError, match=r"/servos: message 1: .*degrees"):
        read_recording(path, scenario(wrong, None), ["a", "b"], file=FILE)


@pytest.mark.parametrize(
    ("asked", "joints", "sentence"),
    [
        (
            scenario("/states"),
            ["a"],
            r"recordings.state: .*no topic /states; it has .*/joint_states \(sensor_msgs/JointS",
        ),
        (scenario(command="/cmd"), ["a"], r"motion.recorded: .*no topic /cmd"),
        (scenario(None), ["a"], r"recordings.state: is missing; .*/joint_states"),
        (scenario(battery="/joint_states"), ["a"], r"/joint_states in .* is a sensor_msgs/JointState; expected a Batt"),
        (scenario(pose="/joint_states"), ["a"], r"recordings.pose: .*expected a PoseStamped"),
        (scenario(imu="/joint_states"), ["a"], r"recordings.imu: .*expected an Imu"),
        (scenario(effort="motor"), ["a"], r"recordings.effort: .*/joint_states holds no effort"),
        (scenario(meaning="duty"), ["a"], r"/joint_commands: holds position, expected effort, .*`as: duty`"),
        (scenario(), ["a", "knee"], r"/joint_states: has no joint knee; it has b, a"),
        (scenario(), ["knee"], r"/joint_states: has no joint knee; it has a, b; expected names as in the URDF"),
    ],
)
def test_what_does_not_fit_is_told_in_one_sentence(
    asked: Scenario, joints: Sequence[str], sentence: str, tmp_path: Path, write_bag: Callable[..., Path]
) -> None:
    path = write_bag(tmp_path / "run", "mcap", two_joints())
    with pytest.raises(InputError, match=sentence):
        read_recording(path, asked, joints, file=FILE)


@pytest.mark.parametrize("share", [0.0, 0.3, 0.9, 0.999])
@pytest.mark.parametrize("form", FORMS)
def test_a_bag_that_was_cut_off(form: str, share: float, tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    path = write_bag(tmp_path / ("run.bag" if form == "bag" else "run"), form, two_joints(400))
    file = path if form == "bag" else next(path.glob(f"*.{form}"))
    data = file.read_bytes()
    file.write_bytes(data[: int(share * len(data))])
    with pytest.raises(InputError, match=r"run.*: the bag (cannot be read|holds no messages)"):
        read_recording(path, scenario(), ["a"], file=FILE)


@pytest.mark.parametrize("form", FORMS)
def test_an_empty_bag(form: str, tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    path = write_bag(tmp_path / ("run.bag" if form == "bag" else "run"), form, [])
    with pytest.raises(InputError, match=r"run.*(holds no messages|cannot be read)"):
        read_recording(path, scenario(), ["a"], file=FILE)


@pytest.mark.parametrize(
    ("form", "name", "sentence"),
    [
        ("mcap", "run.bag", r"run.bag: is an MCAP file; expected a name with \.mcap for it: rename it"),
        ("mcap", "run.csv", r"run.csv: is an MCAP file; expected a name with \.mcap"),
        ("bag", "run.mcap", r"run.mcap: is a bag of ROS 1; expected a name with \.bag"),
        ("db3", "run.mcap", r"run.mcap: is an SQLite database; expected a name with \.db3"),
        (
            "text",
            "run.mcap",
            r"run.mcap: the bag cannot be read: it is text; expected an MCAP file: rename it to \.csv",
        ),
    ],
)
def test_a_file_of_another_kind_than_its_name_says(
    form: str, name: str, sentence: str, tmp_path: Path, write_bag: Callable[..., Path]
) -> None:
    data = b"time,position/a\n0.0,1.0\n"
    if form != "text":
        path = write_bag(tmp_path / ("bag.bag" if form == "bag" else "bag"), form, two_joints())
        data = (path if form == "bag" else next(path.glob(f"*.{form}"))).read_bytes()
    (tmp_path / name).write_bytes(data)
    with pytest.raises(InputError, match=sentence):
        read_recording(tmp_path / name, scenario(), ["a"], file=FILE)


def test_an_empty_folder_and_unknown_files(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"without metadata.yaml and with no \.mcap"):
        read_recording(tmp_path, scenario(), ["a"], file=FILE)
    (tmp_path / "run.txt").write_text("")
    with pytest.raises(
        InputError, match=r"is not a kind of recording that is known here; expected \.bag.* save it as \.csv"
    ):
        read_recording(tmp_path / "run.txt", scenario(), ["a"], file=FILE)
    with pytest.raises(InputError, match="does not exist"):
        read_recording(tmp_path / "none.mcap", scenario(), ["a"], file=FILE)


def test_a_bag_with_a_missing_file(tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    path = write_bag(tmp_path / "run", "mcap", two_joints())
    shutil.move(path / "run.mcap", tmp_path / "elsewhere.mcap")
    with pytest.raises(InputError, match=r"the bag cannot be read .*missing"):
        read_recording(path, scenario(), ["a"], file=FILE)


@pytest.mark.parametrize("suffix", ["gz", "zst"])
@pytest.mark.parametrize("form", FORMS)
def test_a_packed_bag_is_the_same_and_one_that_was_cut_off_is_told(
    form: str, suffix: str, tmp_path: Path, write_bag: Callable[..., Path]
) -> None:
    path = write_bag(tmp_path / "run.bag" if form == "bag" else tmp_path / "run", form, two_joints())
    file = path if form == "bag" else next(path.glob(f"*.{form}"))
    packed = tmp_path / f"run.{form}.{suffix}"
    with pa.output_stream(str(packed), compression={"gz": "gzip", "zst": "zstd"}[suffix]) as target:
        target.write(file.read_bytes())
    whole, again = (read_recording(p, scenario(), ["a", "b"], file=FILE) for p in (path, packed))
    np.testing.assert_array_equal(Signals(again.trace).position, Signals(whole.trace).position)
    np.testing.assert_array_equal(Signals(again.trace).command, Signals(whole.trace).command)
    packed.write_bytes(packed.read_bytes()[:-20])
    with pytest.raises(InputError, match=rf"run.{form}.{suffix}: cannot be unpacked"):
        read_recording(packed, scenario(), ["a", "b"], file=FILE)


@pytest.mark.parametrize("field", ["string[50000000] name", "float64[90000000] position"])
def test_a_message_with_fewer_bytes_than_its_arrays_is_refused_at_once(tmp_path: Path, field: str) -> None:
    """A definition of two lines that would make a list of millions."""
    with Writer(tmp_path / "run", version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        kind = "team_msgs/msg/State"
        connection = writer.add_connection("/joint_states", kind, msgdef=f"{field}\nfloat64[] effort\n", rihs01="x")
        writer.write(connection, 0, b"\0\1\0\0" + bytes(64))
    refused = pytest.raises(InputError, match=r"a team_msgs/State of 68 bytes was found; expected at least [59]0000000")
    with opened(next((tmp_path / "run").glob("*.mcap"))) as bag, refused:
        list(bag.messages({"/joint_states"}))
