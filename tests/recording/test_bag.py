"""What stands in a bag is what comes out, whatever its format, and a bag that is no good says why in one sentence."""

import shutil
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pytest
from realitygap.files.errors import InputError
from realitygap.recording import read_recording
from realitygap.scenario.schema import Scenario

FORMS = ("bag", "mcap", "db3")
STATE = "sensor_msgs/msg/JointState"
EPOCH = 1.7e9
FILE = Path("scenario.yaml")


def scenario(
    state: str | dict[str, Any] | None = "/joint_states",
    command: str | dict[str, Any] | None = "/joint_commands",
    base: str = "fixed",
    meaning: str = "position",
    **recordings: Any,
) -> Scenario:
    return Scenario.model_validate(
        {
            "name": "test",
            "robot": {"urdf": "robot.urdf", "base": base},
            "motion": {"recorded": command, "as": meaning} if command else None,
            "recordings": {"state": state, **recordings},
        }
    )


def two_joints(count: int = 100, period: float = 0.01, **more: Any) -> list[tuple[str, float, str, dict[str, Any]]]:
    """States a = t, b = 2t in the order b, a; commands a = 10 + t, b = 20 + t, half a period later."""
    messages = []
    for k in range(count):
        t = k * period
        state = {"stamp": EPOCH + t, "name": ["b", "a"], "position": [2 * t, t], "velocity": [2.0, 1.0], **more}
        messages.append(("/joint_states", EPOCH + t + 0.002, STATE, state))
        late = t + period / 2
        command = {"stamp": EPOCH + late, "name": ["a", "b"], "position": [10 + late, 20 + late]}
        messages.append(("/joint_commands", EPOCH + late + 0.002, STATE, command))
    return messages


@pytest.mark.parametrize("bare", [False, True])
@pytest.mark.parametrize("form", FORMS)
def test_every_format_gives_the_same(form: str, bare: bool, tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    path = write_bag(tmp_path / "run.bag" if form == "bag" else tmp_path / "run", form, two_joints())
    if bare and form != "bag":
        path = next(path.glob(f"*.{form}"))
    recording = read_recording(path, scenario(), ["a", "b"], file=FILE)
    trace = recording.trace
    time = np.arange(100) * 0.01
    assert trace.joints == ("a", "b")
    assert recording.name == "run"
    np.testing.assert_allclose(trace.time, time, atol=1e-6)
    np.testing.assert_allclose(trace.position, np.column_stack([time, 2 * time]), atol=1e-6)
    np.testing.assert_allclose(trace.velocity, np.tile([1.0, 2.0], (100, 1)))
    assert trace.effort is None
    # held between commands; the first one, 5 ms after the first state, holds before it too
    held = np.maximum(time - 0.005, 0.005)
    np.testing.assert_allclose(trace.command, np.column_stack([10 + held, 20 + held]), atol=1e-6)
    np.testing.assert_allclose(recording.command_time[1:], time + 0.005, atol=1e-6)


def test_a_folder_without_metadata_is_its_one_file(tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    path = write_bag(tmp_path / "run", "mcap", two_joints())
    (path / "metadata.yaml").unlink()
    assert len(read_recording(path, scenario(), ["a"], file=FILE).trace.time) == 100


@pytest.mark.parametrize(
    ("stamp", "clock"),
    [
        ((EPOCH - 5.0, 1.0), "header stamps"),  # a robot whose clock is 5 s behind
        ((0.0, 0.0), "those of reception"),  # never set
        ((EPOCH, 0.0), "those of reception"),  # set once
    ],
)
def test_header_stamps_are_used_where_they_are_sane(
    stamp: tuple[float, float], clock: str, tmp_path: Path, write_bag: Callable[..., Path]
) -> None:
    jitter = np.abs(np.random.default_rng(0).normal(size=50)) * 1e-3
    messages = [
        (
            "/joint_states",
            EPOCH + 0.01 * k + jitter[k],
            STATE,
            {"stamp": stamp[0] + stamp[1] * 0.01 * k, "name": ["a"], "position": [k]},
        )
        for k in range(50)
    ]
    recording = read_recording(write_bag(tmp_path / "run", "mcap", messages), scenario(command=None), ["a"], file=FILE)
    assert clock in recording.notes[0]
    exact = np.abs(recording.trace.time - 0.01 * np.arange(50)).max() < 1e-6
    assert exact == (clock == "header stamps")


def test_clocks_of_two_topics_that_disagree_are_not_mixed(tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    messages = [
        (t, r, kind, {**v, "stamp": v["stamp"] - 100.0} if t == "/joint_commands" else v)
        for t, r, kind, v in two_joints()
    ]
    recording = read_recording(write_bag(tmp_path / "run", "mcap", messages), scenario(), ["a"], file=FILE)
    assert "100 s apart" in recording.notes[0]
    assert recording.trace.time[-1] == pytest.approx(0.99, abs=1e-6)
    assert recording.command_time[-1] == pytest.approx(0.995, abs=1e-6)


def test_repeated_and_disordered_stamps(tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    stamps = [0.0, 0.01, 0.03, 0.02, 0.02, 0.04]
    messages = [
        ("/joint_states", EPOCH + 0.01 * k, STATE, {"stamp": EPOCH + s, "name": ["a"], "position": [float(k)]})
        for k, s in enumerate(stamps)
    ]
    path = write_bag(tmp_path / "run", "db3", messages)
    recording = read_recording(path, scenario(command=None), ["a"], file=FILE)
    np.testing.assert_allclose(recording.trace.time, [0, 0.01, 0.02, 0.03, 0.04], atol=1e-6)
    np.testing.assert_array_equal(recording.trace.position[:, 0], [0, 1, 4, 2, 5])
    assert "1 messages came out of order" in " ".join(recording.notes)
    assert "1 messages repeat the stamp" in " ".join(recording.notes)


def test_a_silent_command_stream_is_a_servo_that_is_off(tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    messages = two_joints(300)
    silent = [m for m in messages if m[0] == "/joint_states" or not 1.0 < m[1] - EPOCH < 2.0]
    recording = read_recording(write_bag(tmp_path / "run", "mcap", silent), scenario(), ["a", "b"], file=FILE)
    off = np.isnan(recording.trace.command[:, 0])
    times = recording.trace.time[off]
    assert times[0] == pytest.approx(1.01, abs=0.011)
    assert times[-1] == pytest.approx(2.0, abs=0.011)
    assert off.sum() == pytest.approx(99, abs=2)
    assert np.isnan(recording.command).any(axis=1).sum() == 1
    assert "servo taken as off" in " ".join(recording.notes)


def test_goals_sent_once_in_a_while_are_held(tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    messages = [m for m in two_joints(1000) if m[0] == "/joint_states"]
    for t in (0.0, 1.0, 1.1, 4.0, 4.1, 4.2, 8.0):
        messages.append(("/joint_commands", EPOCH + t, STATE, {"stamp": EPOCH + t, "name": ["a"], "position": [t]}))
    recording = read_recording(write_bag(tmp_path / "run", "mcap", messages), scenario(), ["a"], file=FILE)
    np.testing.assert_allclose(recording.command[:, 0], [0.0, 1.0, 1.1, 4.0, 4.1, 4.2, 8.0])
    assert np.isfinite(recording.trace.command).all()


def test_commands_for_some_joints_keep_the_others(tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    messages = [m for m in two_joints(20) if m[0] == "/joint_states"]
    for k in range(20):
        name = "ab"[k % 2]
        command = {"stamp": EPOCH + 0.01 * k, "name": [name], "position": [float(k)]}
        messages.append(("/joint_commands", EPOCH + 0.01 * k, STATE, command))
    recording = read_recording(
        write_bag(tmp_path / "run", "mcap", messages), scenario(), ["a", "b", "c"][:2], file=FILE
    )
    np.testing.assert_array_equal(recording.trace.command[4:8, 0], [4, 4, 6, 6])
    np.testing.assert_array_equal(recording.trace.command[4:8, 1], [3, 5, 5, 7])


def test_effort_from_another_topic_with_a_factor(tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    messages = two_joints()
    for k in range(50):  # at half the rate, between the states
        t = 0.02 * k + 0.005
        effort = {"stamp": EPOCH + t, "name": ["a", "b"], "effort": [t, 1.0]}
        messages.append(("/currents", EPOCH + t, STATE, effort))
    asked = scenario(effort={"topic": "/currents", "factor": 2.0})
    trace = read_recording(write_bag(tmp_path / "run", "mcap", messages), asked, ["a", "b"], file=FILE).trace
    np.testing.assert_allclose(trace.effort[1:-1, 0], 2.0 * np.minimum(trace.time[1:-1], 0.985), atol=1e-6)
    np.testing.assert_allclose(trace.effort[:, 1], 2.0)


def test_a_stream_that_ends_early_is_unknown_afterwards(tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    messages = two_joints()
    for k in range(50):
        effort = {"stamp": EPOCH + 0.01 * k, "name": ["a"], "effort": [1.0]}
        messages.append(("/currents", EPOCH + 0.01 * k, STATE, effort))
    asked = scenario(effort={"topic": "/currents"})
    trace = read_recording(write_bag(tmp_path / "run", "mcap", messages), asked, ["a"], file=FILE).trace
    assert np.isfinite(trace.effort[:50]).all()
    assert np.isnan(trace.effort[53:]).all()


QUARTER_TURN = {"w": np.sqrt(0.5), "x": 0.0, "y": 0.0, "z": np.sqrt(0.5)}  # about z


def test_base_imu_and_battery(tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    messages = two_joints()
    for k in range(100):
        t = 0.01 * k
        sign = -1.0 if k % 3 else 1.0  # the same orientation, written two ways
        turn = {axis: sign * v for axis, v in QUARTER_TURN.items()}
        pose = {"pose": {"position": {"x": t, "y": 0.0, "z": 1.0}, "orientation": turn}}
        twist = {"twist": {"linear": {"x": 1.0, "y": 0.0, "z": 0.0}, "angular": {"x": 0.0, "y": 2.0, "z": 3.0}}}
        messages += [
            ("/odom", EPOCH + t, "nav_msgs/msg/Odometry", {"stamp": EPOCH + t, "pose": pose, "twist": twist}),
            ("/imu", EPOCH + t, "sensor_msgs/msg/Imu", {"stamp": EPOCH + t, "angular_velocity": {"x": t}}),
            ("/battery", EPOCH + t, "sensor_msgs/msg/BatteryState", {"stamp": EPOCH + t, "voltage": 15.0 - t}),
        ]
    asked = scenario(base="floating", pose="/odom", imu="/imu", battery="/battery")
    recording = read_recording(write_bag(tmp_path / "run", "mcap", messages), asked, ["a", "b"], file=FILE)
    trace = recording.trace
    np.testing.assert_allclose(trace.base_position[:, 0], trace.time, atol=1e-6)
    np.testing.assert_allclose(trace.base_quaternion, np.tile([np.sqrt(0.5), 0, 0, np.sqrt(0.5)], (100, 1)), atol=1e-6)
    np.testing.assert_allclose(trace.base_linear, np.tile([0, 1.0, 0], (100, 1)), atol=1e-6)  # forward is y there
    np.testing.assert_allclose(trace.base_angular, np.tile([-2.0, 0, 3.0], (100, 1)), atol=1e-6)
    np.testing.assert_allclose(trace.imu_angular[:, 0], trace.time, atol=1e-6)
    assert trace.imu_quaternion is None  # all zeros: this IMU gives no orientation
    np.testing.assert_allclose(trace.supply, 15.0 - trace.time, atol=1e-5)
    np.testing.assert_allclose(recording.supply, 15.0 - recording.supply_time, atol=1e-5)


CONTROLLER = "control_msgs/msg/JointTrajectoryControllerState"
CONTROLLER_TEXT = (
    "std_msgs/Header header\nstring[] joint_names\ntrajectory_msgs/JointTrajectoryPoint desired\n"
    "trajectory_msgs/JointTrajectoryPoint actual\ntrajectory_msgs/JointTrajectoryPoint error\n"
)


def test_a_controller_state_is_state_and_command(tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    messages = []
    for k in range(20):
        t = 0.01 * k
        values = {"desired": {"positions": [t + 1]}, "actual": {"positions": [t], "velocities": [1.0]}}
        messages.append(("/state", EPOCH + t, CONTROLLER, {"stamp": EPOCH + t, "joint_names": ["a"], **values}))
    path = write_bag(tmp_path / "run", "mcap", messages, {CONTROLLER: CONTROLLER_TEXT})
    trace = read_recording(path, scenario("/state", "/state"), ["a"], file=FILE).trace
    np.testing.assert_allclose(trace.command - trace.position, 1.0)
    np.testing.assert_allclose(trace.velocity, 1.0)


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
    trace = read_recording(path, scenario(stream, None, effort="joint"), ["a", "b"], file=FILE).trace
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
        (scenario(), ["a", "knee"], r"/joint_states: message 1: has no joint knee; it has b, a"),
        (scenario(), ["knee"], r"/joint_states: has no joint knee; it has a, b; expected names as in the URDF"),
    ],
)
def test_what_does_not_fit_is_told_in_one_sentence(
    asked: Scenario, joints: Sequence[str], sentence: str, tmp_path: Path, write_bag: Callable[..., Path]
) -> None:
    path = write_bag(tmp_path / "run", "mcap", two_joints())
    with pytest.raises(InputError, match=sentence):
        read_recording(path, asked, joints, file=FILE)


def test_values_that_are_not_finite(tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    messages = two_joints()
    messages[80][3]["position"][0] = np.nan
    path = write_bag(tmp_path / "run", "mcap", messages)
    with pytest.raises(InputError, match=r"/joint_states: position of joint b is nan at 0.400 s \(1 such"):
        read_recording(path, scenario(), ["a", "b"], file=FILE)


def test_signals_that_were_never_measured_are_left_out(tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    path = write_bag(tmp_path / "run", "mcap", two_joints(velocity=[np.nan, np.nan]))
    assert read_recording(path, scenario(), ["a", "b"], file=FILE).trace.velocity is None


def test_names_and_values_of_different_length(tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    path = write_bag(tmp_path / "run", "mcap", two_joints(position=[1.0]))
    with pytest.raises(InputError, match="message 1: names 2 joints and holds 1 values of position"):
        read_recording(path, scenario(), ["a"], file=FILE)


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


def test_an_empty_folder_and_unknown_files(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"without metadata.yaml and with no \.mcap"):
        read_recording(tmp_path, scenario(), ["a"], file=FILE)
    (tmp_path / "run.txt").write_text("")
    with pytest.raises(InputError, match=r"is not a kind of recording that is known here; expected \.bag"):
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
    np.testing.assert_array_equal(again.trace.position, whole.trace.position)
    np.testing.assert_array_equal(again.trace.command, whole.trace.command)
    packed.write_bytes(packed.read_bytes()[:-20])
    with pytest.raises(InputError, match=rf"run.{form}.{suffix}: cannot be unpacked"):
        read_recording(packed, scenario(), ["a", "b"], file=FILE)
