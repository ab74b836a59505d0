"""Streams of a bag become one recording: clocks, order, silence, several topics, a base, a controller's state."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from bags import EPOCH, FILE, STATE, scenario, two_joints
from realitygap.files.errors import InputError
from realitygap.recording import read_recording
from signals import Signals, there


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
    (lack,) = recording.absent
    assert (lack.kind, lack.text, lack.of_readings) == ("clock", recording.notes[0], False)
    assert recording.trace.time[-1] == pytest.approx(0.99, abs=1e-6)
    assert recording.command_time[-1] == pytest.approx(0.995, abs=1e-6)


def test_a_header_clock_that_was_set_back_is_named(tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    messages = [
        (t, r, kind, {**v, "stamp": v["stamp"] - 100.0} if t == "/joint_states" and r > EPOCH + 0.3 else v)
        for t, r, kind, v in two_joints()
    ]
    recording = read_recording(write_bag(tmp_path / "run", "mcap", messages), scenario(), ["a"], file=FILE)
    told = "times are those of reception: the clock of the header stamps of /joint_states jumps by 100 s"
    assert (recording.notes[0], [lack.text for lack in recording.absent]) == (told, [told])


def test_repeated_and_disordered_stamps(tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    stamps = [0.0, 0.01, 0.03, 0.02, 0.02, 0.04]
    messages = [
        ("/joint_states", EPOCH + 0.01 * k, STATE, {"stamp": EPOCH + s, "name": ["a"], "position": [float(k)]})
        for k, s in enumerate(stamps)
    ]
    path = write_bag(tmp_path / "run", "db3", messages)
    recording = read_recording(path, scenario(command=None), ["a"], file=FILE)
    np.testing.assert_allclose(recording.trace.time, [0, 0.01, 0.02, 0.03, 0.04], atol=1e-6)
    np.testing.assert_array_equal(Signals(recording.trace).position[:, 0], [0, 1, 4, 2, 5])
    assert "1 messages came out of order" in " ".join(recording.notes)
    assert "1 messages repeat the stamp" in " ".join(recording.notes)


def test_a_silent_command_stream_is_a_servo_that_is_off(tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    messages = two_joints(300)
    silent = [m for m in messages if m[0] == "/joint_states" or not 1.0 < m[1] - EPOCH < 2.0]
    recording = read_recording(write_bag(tmp_path / "run", "mcap", silent), scenario(), ["a", "b"], file=FILE)
    off = np.isnan(Signals(recording.trace).command[:, 0])
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
    assert np.isfinite(Signals(recording.trace).command).all()


def test_commands_for_some_joints_keep_the_others(tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    messages = [m for m in two_joints(20) if m[0] == "/joint_states"]
    for k in range(20):
        name = "ab"[k % 2]
        command = {"stamp": EPOCH + 0.01 * k, "name": [name], "position": [float(k)]}
        messages.append(("/joint_commands", EPOCH + 0.01 * k, STATE, command))
    recording = read_recording(
        write_bag(tmp_path / "run", "mcap", messages), scenario(), ["a", "b", "c"][:2], file=FILE
    )
    np.testing.assert_array_equal(Signals(recording.trace).command[4:8, 0], [4, 4, 6, 6])
    np.testing.assert_array_equal(Signals(recording.trace).command[4:8, 1], [3, 5, 5, 7])


def test_effort_from_another_topic_with_a_factor(tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    messages = two_joints()
    for k in range(50):  # at half the rate, between the states
        t = 0.02 * k + 0.005
        effort = {"stamp": EPOCH + t, "name": ["a", "b"], "effort": [t, 1.0]}
        messages.append(("/currents", EPOCH + t, STATE, effort))
    asked = scenario(effort={"topic": "/currents", "factor": 2.0})
    trace = Signals(read_recording(write_bag(tmp_path / "run", "mcap", messages), asked, ["a", "b"], file=FILE).trace)
    np.testing.assert_allclose(trace.effort[1:-1, 0], 2.0 * np.minimum(trace.time[1:-1], 0.985), atol=1e-6)
    np.testing.assert_allclose(trace.effort[:, 1], 2.0)


@pytest.mark.parametrize(
    ("sent", "known", "unknown"),
    [(range(50), slice(50), slice(53, None)), (range(50, 100), slice(50, None), slice(47))],
    ids=["ends early", "begins late"],
)
def test_a_stream_is_unknown_before_and_after(
    sent: range, known: slice, unknown: slice, tmp_path: Path, write_bag: Callable[..., Path]
) -> None:
    messages = two_joints()
    for k in sent:
        effort = {"stamp": EPOCH + 0.01 * k, "name": ["a"], "effort": [1.0]}
        messages.append(("/currents", EPOCH + 0.01 * k, STATE, effort))
    asked = scenario(effort={"topic": "/currents"})
    trace = Signals(read_recording(write_bag(tmp_path / "run", "mcap", messages), asked, ["a"], file=FILE).trace)
    assert np.isfinite(trace.effort[known]).all()
    assert np.isnan(trace.effort[unknown]).all()


def test_every_joint_has_its_own_factor_of_an_effort(tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    path = write_bag(tmp_path / "run", "mcap", two_joints(effort=[5.0, 7.0]))
    asked = scenario(effort={"topic": "/joint_states", "factor": {"b": -3.0, "*": 2.0}})
    trace = Signals(read_recording(path, asked, ["a", "b"], file=FILE).trace)
    np.testing.assert_allclose(trace.effort, np.tile([14.0, -15.0], (100, 1)))


def test_time_begins_with_the_first_message_of_whatever_stream(tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    """Windows are told in seconds from there."""
    messages = two_joints()
    messages.append(("/joint_commands", EPOCH - 0.25, STATE, {"stamp": EPOCH - 0.25, "name": ["a"], "position": [9.0]}))
    recording = read_recording(write_bag(tmp_path / "run", "mcap", messages), scenario(), ["a", "b"], file=FILE)
    assert recording.command_time[0] == 0.0
    np.testing.assert_allclose(recording.trace.time, 0.25 + 0.01 * np.arange(100), atol=1e-6)
    np.testing.assert_allclose(Signals(recording.trace).position[:, 0], recording.trace.time - 0.25, atol=1e-6)


def test_orientations_between_two_are_orientations(tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    """A base that turns by half a turn between two poses; what is interpolated has unit length."""
    messages = two_joints(41)
    for k in range(3):
        t, half = 0.2 * k, 0.5 * np.pi * k / 2
        pose = {"position": {"z": 1.0}, "orientation": {"w": np.cos(half), "z": np.sin(half)}}
        messages.append(("/pose", EPOCH + t, "geometry_msgs/msg/PoseStamped", {"stamp": EPOCH + t, "pose": pose}))
    asked = scenario(base="floating", pose="/pose")
    recording = read_recording(write_bag(tmp_path / "run", "mcap", messages), asked, ["a", "b"], file=FILE)
    quaternion = Signals(recording.trace).base_quaternion
    np.testing.assert_allclose(np.linalg.norm(quaternion, axis=1), 1.0)
    np.testing.assert_allclose(quaternion[10], [np.cos(np.pi / 8), 0, 0, np.sin(np.pi / 8)], atol=1e-6)


@pytest.mark.parametrize(("covariance", "known"), [(0.0, True), (-1.0, False)])
def test_an_imu_says_whether_it_has_an_orientation(
    covariance: float, known: bool, tmp_path: Path, write_bag: Callable[..., Path]
) -> None:
    """A covariance that begins with -1: what stands there is none (sensor_msgs/Imu)."""
    messages = two_joints()
    for k in range(100):
        told = {"orientation": {"w": 1.0}, "orientation_covariance": [covariance] + [0.0] * 8}
        messages.append(("/imu", EPOCH + 0.01 * k, "sensor_msgs/msg/Imu", {"stamp": EPOCH + 0.01 * k, **told}))
    asked = scenario(base="floating", imu="/imu")
    trace = read_recording(write_bag(tmp_path / "run", "mcap", messages), asked, ["a", "b"], file=FILE).trace
    assert (trace.imu_quaternion is not None) == known
    assert trace.imu_angular is not None


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
            ("/warm", EPOCH + t, "sensor_msgs/msg/Temperature", {"stamp": EPOCH + t, "temperature": 30.0 + t}),
        ]
    asked = scenario(base="floating", pose="/odom", imu="/imu", battery="/battery", temperature="/warm")
    recording = read_recording(write_bag(tmp_path / "run", "mcap", messages), asked, ["a", "b"], file=FILE)
    trace = Signals(recording.trace)
    np.testing.assert_allclose(trace.base_position[:, 0], trace.time, atol=1e-6)
    np.testing.assert_allclose(trace.base_quaternion, np.tile([np.sqrt(0.5), 0, 0, np.sqrt(0.5)], (100, 1)), atol=1e-6)
    np.testing.assert_allclose(trace.base_linear, np.tile([0, 1.0, 0], (100, 1)), atol=1e-6)  # forward is y there
    np.testing.assert_allclose(trace.base_angular, np.tile([-2.0, 0, 3.0], (100, 1)), atol=1e-6)
    np.testing.assert_allclose(trace.imu_angular[:, 0], trace.time, atol=1e-6)
    assert trace.trace.imu_quaternion is None  # all zeros: this IMU gives no orientation
    np.testing.assert_allclose(trace.supply, 15.0 - trace.time, atol=1e-5)
    np.testing.assert_allclose(recording.supply, 15.0 - recording.supply_time, atol=1e-5)
    np.testing.assert_allclose(
        there(recording.trace.temperature), np.tile(30.0 + trace.time[:, None], (1, 2)), atol=1e-5
    )


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
    trace = Signals(read_recording(path, scenario("/state", "/state"), ["a"], file=FILE).trace)
    np.testing.assert_allclose(trace.command - trace.position, 1.0)
    np.testing.assert_allclose(trace.velocity, 1.0)


def test_values_that_are_not_finite(tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    messages = two_joints()
    messages[80][3]["position"][0] = np.inf
    path = write_bag(tmp_path / "run", "mcap", messages)
    with pytest.raises(InputError, match=r"/joint_states: position of joint b is inf in sample 41 of 100 \(1 such"):
        read_recording(path, scenario(), ["a", "b"], file=FILE)


def test_messages_without_a_position_are_left_out_and_nothing_else(
    tmp_path: Path, write_bag: Callable[..., Path]
) -> None:
    messages = two_joints()
    for k in (0, 40, 41):  # states of a robot that starts up, and of a bus that loses a servo for a while
        messages[2 * k][3]["position"][0] = np.nan
    recording = read_recording(write_bag(tmp_path / "run", "mcap", messages), scenario(), ["a", "b"], file=FILE)
    kept = np.delete(0.01 * np.arange(100), (0, 40, 41))
    np.testing.assert_allclose(recording.trace.time, kept, atol=1e-6)
    np.testing.assert_allclose(Signals(recording.trace).position, np.column_stack([kept, 2 * kept]), atol=1e-6)
    assert len(there(recording.receive_time)) == 97
    assert len(recording.command_time) == 100
    assert any("3 of 100 samples are left out, as they are without the position of b (3)" in n for n in recording.notes)


def test_signals_that_were_never_measured_are_left_out(tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    path = write_bag(tmp_path / "run", "mcap", two_joints(velocity=[np.nan, np.nan]))
    assert read_recording(path, scenario(), ["a", "b"], file=FILE).trace.velocity is None


def test_a_joint_that_a_message_names_twice_is_told_where_it_is_asked_for(
    tmp_path: Path, write_bag: Callable[..., Path]
) -> None:
    path = write_bag(tmp_path / "run", "mcap", two_joints(name=["b", "a", "b"], position=[1.0, 2.0, 3.0]))
    with pytest.raises(InputError, match="message 1: names joint b twice: b, a, b; expected every joint once"):
        read_recording(path, scenario(), ["a", "b"], file=FILE)


def test_an_episode_of_a_bag_is_told(tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    path = write_bag(tmp_path / "run", "mcap", two_joints())
    with pytest.raises(InputError, match=r"found episode 3 of .*run; expected a data set with meta/info\.json"):
        read_recording(path, scenario(episode=3), ["a", "b"], file=FILE)


def test_names_and_values_of_different_length(tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    path = write_bag(tmp_path / "run", "mcap", two_joints(position=[1.0]))
    with pytest.raises(InputError, match="message 1: names 2 joints and holds 1 values of position"):
        read_recording(path, scenario(), ["a"], file=FILE)
