"""The messages of ros2_control give the same motion as a JointState, and a trajectory what a controller makes of it."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from realitygap.files.errors import InputError
from realitygap.init.draft import init
from realitygap.recording import read_recording
from realitygap.recording.recording import Recording
from realitygap.scenario.file import load_scenario
from realitygap.scenario.schema import Scenario
from signals import Signals, there

FILE = Path("scenario.yaml")
Message = tuple[str, float, str, dict[str, Any]]
EPOCH = 1.7e9
STATE = "sensor_msgs/msg/JointState"
ARRAY = "std_msgs/msg/Float64MultiArray"
TRAJECTORY = "trajectory_msgs/msg/JointTrajectory"
CONTROLLER = "control_msgs/msg/JointTrajectoryControllerState"
DYNAMIC = "control_msgs/msg/DynamicJointState"
POINT = "trajectory_msgs/JointTrajectoryPoint"
DEFINITIONS = {
    CONTROLLER: f"std_msgs/Header header\nstring[] joint_names\n{POINT} reference\n{POINT} feedback\n{POINT} error\n"
    f"{POINT} output\n{POINT} desired\n{POINT} actual\n",
    "control_msgs/msg/InterfaceValue": "string[] interface_names\nfloat64[] values\n",
    DYNAMIC: "std_msgs/Header header\nstring[] joint_names\ncontrol_msgs/InterfaceValue[] interface_values\n",
}
JOINTS = ("a", "b")
MASS = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
LIMIT = '<axis xyz="0 1 0"/><limit lower="-9" upper="9" effort="5" velocity="9"/></joint>'
URDF = f"""<robot name="arm"><link name="base"/><link name="la">{MASS}</link><link name="lb">{MASS}</link>
<joint name="a" type="revolute"><parent link="base"/><child link="la"/>{LIMIT}
<joint name="b" type="revolute"><parent link="la"/><child link="lb"/>{LIMIT}</robot>"""


def measured(t: Any) -> list[Any]:
    return [np.sin(3 * t), 0.5 * np.cos(2 * t)]


def asked(t: Any) -> list[Any]:
    return measured(t + 0.05)


def scenario(state: str | dict[str, Any] = "/joint_states", command: str | None = None, **motion: Any) -> Scenario:
    raw = {"name": "test", "robot": {"urdf": "robot.urdf", "base": "fixed"}, "recordings": {"state": state}}
    return Scenario.model_validate(raw | {"motion": {"recorded": command, **motion} if command else None})


def states(count: int = 200, period: float = 0.01) -> list[Message]:
    return [("/joint_states", EPOCH + k * period, STATE, state(k * period)) for k in range(count)]


def state(t: float) -> dict[str, Any]:
    return {"stamp": EPOCH + t, "name": ["b", "a"], "position": measured(t)[::-1], "velocity": [t, 2 * t]}


def messages(kind: str, name: str, count: int = 200) -> list[Message]:
    """The same motion in every kind of message, joints in the order b, a; arrays have no header."""
    out = []
    for k in range(count):
        t = 0.01 * k
        point = {"positions": measured(t)[::-1], "velocities": [t, 2 * t]}
        told = {"positions": asked(t)[::-1]}
        values: dict[str, dict[str, Any]] = {
            STATE: {"stamp": EPOCH + t, "name": ["b", "a"], "position": asked(t)[::-1]},
            ARRAY: {"data": asked(t)[::-1]},
            CONTROLLER: controller(t, {"feedback": point, "reference": told}),
            "old": controller(t, {"actual": point, "desired": told}),
            DYNAMIC: dynamic(t),
        }
        out.append((name, EPOCH + t, CONTROLLER if kind == "old" else kind, values[kind]))
    return out


def controller(t: float, points: Any) -> dict[str, Any]:
    return {"stamp": EPOCH + t, "joint_names": ["b", "a"], **points}


def dynamic(t: float) -> dict[str, Any]:
    a, b = measured(t)
    rows = [
        {"interface_names": ["velocity", "temperature", "position"], "values": [t, 40.0, b]},
        {"interface_names": ["position", "velocity"], "values": [a, 2 * t]},
    ]
    return {"stamp": EPOCH + t, "joint_names": ["b", "a"], "interface_values": rows}


def read(bag: Path, want: Scenario, joints: Sequence[str] = JOINTS) -> Recording:
    return read_recording(bag, want, joints, file=FILE)


@pytest.mark.parametrize("form", ["mcap", "db3"])
@pytest.mark.parametrize("kind", [STATE, CONTROLLER, "old", DYNAMIC])
def test_the_same_state_in_every_message(kind: str, form: str, tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    sent = states() if kind == STATE else messages(kind, "/joint_states")
    trace = Signals(read(write_bag(tmp_path / "run", form, sent, DEFINITIONS), scenario()).trace)
    time = np.arange(200) * 0.01
    np.testing.assert_allclose(trace.time, time, atol=1e-6)
    np.testing.assert_allclose(trace.position, np.transpose(measured(time)), atol=1e-12)
    np.testing.assert_allclose(trace.velocity, np.column_stack([2 * time, time]), atol=1e-12)


@pytest.mark.parametrize("kind", [STATE, ARRAY, CONTROLLER, "old"])
def test_the_same_command_in_every_message(kind: str, tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    sent = [*states(), *messages(kind, "/told")]
    named: dict[str, Any] = {"joints": ["b", "a"]} if kind == ARRAY else {}
    want = scenario(command="/told", **named)
    trace = Signals(read(write_bag(tmp_path / "run", "mcap", sent, DEFINITIONS), want).trace)
    np.testing.assert_allclose(trace.command, np.transpose(asked(trace.time)), atol=1e-6)


def test_an_array_needs_names_and_as_many_values(tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    bag = write_bag(tmp_path / "run", "mcap", [*states(), *messages(ARRAY, "/told")])
    with pytest.raises(InputError, match=r"motion.joints: is missing; /told .*is a std_msgs/Float64MultiArray"):
        read(bag, scenario(command="/told"))
    with pytest.raises(InputError, match=r"/told: message 1: holds 2 values, but 3 joints are named: b, a, c"):
        read(bag, scenario(command="/told", joints=["b", "a", "c"]))
    with pytest.raises(InputError, match=r"recordings.state.joints: is missing; /told"):
        read(bag, scenario("/told"))


def test_an_effort_command_of_an_array(tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    bag = write_bag(tmp_path / "run", "mcap", [*states(), *messages(ARRAY, "/told")])
    recording = read(bag, scenario(command="/told", joints=["b", "a"], **{"as": "effort"}))
    assert recording.command_kind == "effort"
    np.testing.assert_allclose(Signals(recording.trace).command, np.transpose(asked(recording.trace.time)), atol=1e-6)


def goal(start: float, points: Any, names: Sequence[str] = ("b", "a"), stamp: bool = True) -> Message:
    """A trajectory: points are (time from start, {field: values})."""
    rows = []
    for after, values in points:
        sec = int(after)
        rows.append({"time_from_start": {"sec": sec, "nanosec": round((after - sec) * 1e9)}, **values})
    header = {"stamp": EPOCH + start} if stamp else {}
    return ("/goal", EPOCH + start, TRAJECTORY, {**header, "joint_names": list(names), "points": rows})


def trajectory(tmp_path: Path, write_bag: Callable[..., Path], goals: list[Message], **motion: Any) -> Signals:
    bag = write_bag(tmp_path / "run", "mcap", [*states(400), *goals])
    return Signals(read(bag, scenario(command="/goal", held=False, **motion)).trace)


@pytest.mark.parametrize("stamp", [True, False])
def test_points_with_positions_are_joined_linearly_from_where_the_robot_was(
    stamp: bool, tmp_path: Path, write_bag: Callable[..., Path]
) -> None:
    points = [(0.5, {"positions": [2.0, 1.0]}), (1.5, {"positions": [0.0, 3.0]})]
    trace = trajectory(tmp_path, write_bag, [goal(1.0, points, stamp=stamp)])
    a, b = measured(1.0)
    knots = [1.0, 1.5, 2.5]
    where = trace.time >= 1.0
    expected = [np.interp(trace.time[where], knots, [start, *then]) for start, then in ((a, [1, 3]), (b, [2, 0]))]
    np.testing.assert_allclose(trace.command[where], np.transpose(expected), atol=0.03)  # held up to 5 ms
    assert np.isnan(trace.command[trace.time < 0.7]).all()
    np.testing.assert_allclose(trace.command[trace.time > 2.51], np.tile([3.0, 0.0], ((trace.time > 2.51).sum(), 1)))


@pytest.mark.parametrize("accelerations", [False, True])
def test_points_with_velocities_are_a_smooth_curve(
    accelerations: bool, tmp_path: Path, write_bag: Callable[..., Path]
) -> None:
    """Points of t³ (or t⁴ with accelerations) give t³ (t⁴) back."""
    power = 4 if accelerations else 3
    points = []
    for t in (0.0, 0.5, 1.0, 2.0):
        values = {"positions": [t**power, -(t**power)], "velocities": [power * t ** (power - 1)] * 2}
        values["velocities"][1] *= -1
        if accelerations:
            second = power * (power - 1) * t ** (power - 2)
            values["accelerations"] = [second, -second]
        points.append((t, values))
    trace = trajectory(tmp_path, write_bag, [goal(1.0, points)])
    inside = (trace.time > 1.001) & (trace.time < 2.99)
    on_grid = 1.0 + 0.005 * np.floor((trace.time[inside] - 1.0) / 0.005 + 1e-6)
    expected = (on_grid - 1.0) ** power
    np.testing.assert_allclose(trace.command[inside], np.column_stack([-expected, expected]), atol=2e-3)


def test_a_new_trajectory_replaces_the_rest_of_an_old_one(tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    first = goal(0.0, [(0.0, {"positions": [0.0, 0.0]}), (2.0, {"positions": [2.0, 2.0]})])
    second = goal(1.0, [(1.0, {"positions": [0.0]})], names=("a",))  # one joint turns back, the other goes on
    command = trajectory(tmp_path, write_bag, [first, second]).command
    np.testing.assert_allclose(command[150], [0.5, 1.5], atol=0.006)
    np.testing.assert_allclose(command[250], [0.0, 2.0], atol=0.006)


def test_a_trajectory_in_degrees_begins_where_the_robot_was(tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    """Which was measured in rad."""
    bag = write_bag(tmp_path / "run", "mcap", [*states(400), goal(1.0, [(1.0, {"positions": [90.0, 180.0]})])])
    said = scenario(command="/goal", held=False).model_dump(by_alias=True)
    said["recordings"]["columns"] = {"units": {"command": "deg"}}
    trace = Signals(read(bag, Scenario.model_validate(said)).trace)
    begin, end = np.searchsorted(trace.time, [1.0 + 1e-4, 2.1])
    np.testing.assert_allclose(trace.command[begin], measured(1.0), atol=0.03)
    np.testing.assert_allclose(trace.command[end], [np.pi, np.pi / 2])


def test_what_is_wrong_with_a_trajectory_is_told(tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    cases = [
        (goal(0.0, [(1.0, {"positions": [1.0, 1.0]}), (0.5, {"positions": [1.0, 1.0]})]), r"does not increase"),
        (goal(0.0, [(1.0, {"velocities": [1.0, 1.0]})]), r"points without positions"),
        (goal(0.0, [(1.0, {"positions": [1.0]})]), r"names 2 joints and holds another number of positions"),
        (goal(0.0, [(1.0, {"positions": [1.0]})], names=("c",)), r"has no trajectory of a, b; it has c"),
    ]
    for k, (message, sentence) in enumerate(cases):
        bag = write_bag(tmp_path / f"run{k}", "mcap", [*states(), message])
        with pytest.raises(InputError, match=sentence):
            read(bag, scenario(command="/goal"))


@pytest.mark.parametrize(
    ("kind", "topic", "expected"),
    [
        (ARRAY, "/position_controller/commands", {"joints": ["b", "a"], "held": False}),  # a trajectory at 100 Hz
        (CONTROLLER, "/arm_controller/controller_state", {"joints": None, "held": False}),
        (TRAJECTORY, "/goal", {"joints": None, "held": False}),
    ],
)
def test_a_first_scenario_finds_the_command(
    kind: str, topic: str, expected: dict[str, Any], tmp_path: Path, write_bag: Callable[..., Path]
) -> None:
    points = [(0.1 * k + 0.01, {"positions": asked(0.1 * k)[::-1]}) for k in range(20)]
    told = [goal(0.0, points)] if kind == TRAJECTORY else messages(kind, topic)
    urdf = tmp_path / "arm.urdf"
    urdf.write_text(URDF)
    bag = write_bag(
        tmp_path / "run", "mcap", [*states(), *messages(DYNAMIC, "/dynamic_joint_states"), *told], DEFINITIONS
    )
    draft = init(urdf, [bag], tmp_path / "out")
    found = load_scenario(draft.path).scenario
    assert there(found.recordings).state == "/joint_states"
    assert there(found.motion).recorded == topic
    assert {"joints": there(found.motion).joints, "held": there(found.motion).held} == expected
    assert "not used: /dynamic_joint_states (control_msgs/DynamicJointState)" in draft.lines()


def test_dynamic_states_alone_are_the_state(tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    urdf = tmp_path / "arm.urdf"
    urdf.write_text(URDF)
    sent = messages(DYNAMIC, "/dynamic_joint_states")
    draft = init(urdf, [write_bag(tmp_path / "run", "mcap", sent, DEFINITIONS)], tmp_path / "out")
    assert there(load_scenario(draft.path).scenario.recordings).state == "/dynamic_joint_states"
    assert "note: no topic of commands was found: without motion, nothing drives the joints" in draft.lines()


@pytest.mark.parametrize("meaning", ["effort", "velocity"])
def test_the_commands_of_effort_and_velocity_controllers_are_offered(
    meaning: str, tmp_path: Path, write_bag: Callable[..., Path]
) -> None:
    urdf = tmp_path / "arm.urdf"
    urdf.write_text(URDF)
    sent = [*states(), *messages(ARRAY, f"/{meaning}_controller/commands")]
    draft = init(urdf, [write_bag(tmp_path / "run", "mcap", sent)], tmp_path / "out")
    found = load_scenario(draft.path).scenario
    motion = there(found.motion)
    assert (motion.recorded, motion.meaning) == (f"/{meaning}_controller/commands", meaning)
    assert (motion.joints, [servo.kind for servo in found.servos]) == (["a", "b"], [meaning])
    assert any("this is the robot's order" in line for line in draft.lines())
