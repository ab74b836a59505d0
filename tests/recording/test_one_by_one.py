"""Commands of which every joint has a topic of its own, as ROS 1 and ros_control send them."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bags import EPOCH, FILE, STATE, scenario
from first_scenario import arm, goal, read_all
from realitygap.files.errors import InputError
from realitygap.init.draft import init
from realitygap.recording import read_recording
from realitygap.scenario.schema import Scenario
from signals import Signals, there

FLOAT, ARRAY = "std_msgs/msg/Float64", "std_msgs/msg/Float64MultiArray"
TIME = np.arange(200) * 0.01
JOINTS = ("joint1", "joint2")
Message = tuple[str, float, str, dict[str, Any]]
POSITIONS = "/{}_position_controller/command"


def asked(j: int, t: Any) -> Any:
    return goal(t) + j


def states(joints: tuple[str, ...] = JOINTS) -> list[Message]:
    values = [(EPOCH + t, {"position": [asked(j, t - 0.05) for j in range(len(joints))]}) for t in TIME]
    return [("/joint_states", stamp, STATE, {"stamp": stamp, "name": list(joints), **value}) for stamp, value in values]


def commands(topics: dict[str, int], kind: str = FLOAT, every: int = 2, late: float = 3e-3) -> list[Message]:
    """Of joints by their numbers, each a little after the one before and `late` [s] after every second sample."""
    return [
        (topic, EPOCH + t + late + 1e-4 * j, kind, {"data": [asked(j, t)] if kind == ARRAY else asked(j, t)})
        for t in TIME[::every]
        for topic, j in topics.items()
    ]


def of(recorded: Any, **motion: Any) -> Scenario:
    stated = scenario().model_dump(by_alias=True, exclude_unset=True)
    return Scenario.model_validate(stated | {"motion": {"recorded": recorded, **motion}})


@pytest.mark.parametrize("kind", [FLOAT, ARRAY])
@pytest.mark.parametrize("form", ["bag", "mcap"])
@pytest.mark.parametrize("recorded", [{"*": POSITIONS}, {j: POSITIONS.format(j) for j in JOINTS}])
def test_every_joint_gets_the_command_of_its_topic(
    recorded: dict[str, str], form: str, kind: str, tmp_path: Path, write_bag: Callable[..., Path]
) -> None:
    sent = commands({POSITIONS.format(joint): j for j, joint in enumerate(JOINTS)}, kind)
    path = write_bag(tmp_path / ("run.bag" if form == "bag" else "run"), form, [*states(), *sent])
    stated = of({joint: topic.format("*") for joint, topic in recorded.items()})
    recording = read_recording(path, stated, JOINTS, file=FILE)
    held = 2 * ((np.arange(1, len(TIME)) - 1) // 2)  # the last one that was sent before a sample
    expected = np.column_stack([asked(j, TIME[held]) for j in (0, 1)])
    np.testing.assert_allclose(Signals(recording.trace).command[1:], expected)


@pytest.mark.parametrize(
    ("topics", "meaning", "line"),
    [
        (POSITIONS, "position", '{"*": "/*_position_controller/command"}'),
        ("/arm/{}_effort_controller/command", "effort", '{"*": "/arm/*_effort_controller/command"}'),
        ("/{}/velocity_cmd", "velocity", '{"*": "/*/velocity_cmd"}'),
        ("/servo_{n}_goal", "position", '{"joint1": "/servo_1_goal", "joint2": "/servo_2_goal"}'),
    ],
)
def test_a_first_scenario_names_them(
    topics: str, meaning: str, line: str, tmp_path: Path, write_bag: Callable[..., Path]
) -> None:
    named = {topics.format(joint, n=j + 1): j for j, joint in enumerate(JOINTS)}
    other = [("/battery_voltage", EPOCH + t, FLOAT, {"data": 12.0}) for t in TIME]
    path = write_bag(tmp_path / "run.bag", "bag", [*states(), *commands(named, every=1, late=0.0), *other])
    draft = init(arm(tmp_path / "arm.urdf", JOINTS), [path], tmp_path / "out")
    stated, (recording,) = read_all(draft.path, JOINTS)
    assert f"recorded: {line}" in draft.path.read_text()
    assert (there(stated.motion).meaning, recording.command_kind) == (meaning, meaning)
    np.testing.assert_allclose(Signals(recording.trace).command[1:, 0], asked(0, TIME[1:]))
    assert draft.told[0] == "not used: /battery_voltage (std_msgs/Float64)"


def test_a_joint_without_commands_is_never_commanded(tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    path = write_bag(tmp_path / "run.bag", "bag", [*states(), *commands({POSITIONS.format("joint2"): 1})])
    draft = init(arm(tmp_path / "arm.urdf", JOINTS), [path], tmp_path / "out")
    _, (recording,) = read_all(draft.path, JOINTS)
    assert "never commanded: joint1" in recording.notes
    assert np.isfinite(recording.command[:, 1]).all()


@pytest.mark.parametrize(
    ("recorded", "sentence"),
    [
        ({"*": "/*_controller/command"}, r"motion.recorded: .* has no topic /joint1_controller/command; it has "),
        ({"*": POSITIONS.format("joint1")}, r"gives joint1 and joint2 the same topic .*expected another for each"),
        (
            POSITIONS.format("*"),
            r"has no topic /\*_position_controller/command; .*; a pattern is written as \{\"\*\": ",
        ),
        ({"hip": "/hip/command"}, r"motion.recorded: hip matches no joint; the robot has joint1, joint2"),
        ({"joint1": "/joint_states"}, r"/joint_states in .* is a sensor_msgs/JointState; expected a Float64 of one"),
        ({"joint1": "/pair"}, r"/pair: message 1: holds 2 values, but 1 joints are named: joint1"),
    ],
)
def test_what_does_not_fit_is_told(
    recorded: str | dict[str, str], sentence: str, tmp_path: Path, write_bag: Callable[..., Path]
) -> None:
    pair = [("/pair", EPOCH + t, ARRAY, {"data": [0.0, 1.0]}) for t in TIME]
    path = write_bag(tmp_path / "run.bag", "bag", [*states(), *commands({POSITIONS.format("joint1"): 0}), *pair])
    with pytest.raises(InputError, match=sentence):
        read_recording(path, of(recorded), JOINTS, file=FILE)


def test_joints_beside_topics_by_joint_are_refused() -> None:
    with pytest.raises(ValueError, match="found joints beside a topic for each of them"):
        of({"*": "/*/command"}, joints=["joint1"])
