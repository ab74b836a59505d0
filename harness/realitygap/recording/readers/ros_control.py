"""The messages of ros2_control: controller states, dynamic joint states, arrays without names."""

from typing import Any

import numpy as np

from realitygap.recording.readers.messages import JointMessages, Layout, layout_of
from realitygap.recording.readers.trajectory import Trajectories
from realitygap.scenario.schema import Stream

CONTROLLER_STATE = "control_msgs/msg/JointTrajectoryControllerState"
DYNAMIC_STATE = "control_msgs/msg/DynamicJointState"
TRAJECTORY = "trajectory_msgs/msg/JointTrajectory"
ARRAYS = ("std_msgs/msg/Float64MultiArray", "std_msgs/msg/Float32MultiArray")
MEASURED, ASKED = ("feedback", "actual"), ("reference", "desired")
"""What a controller state measures and asks for, by the names of today and of ROS 1 and early ROS 2."""
POINT = {"position": "positions", "velocity": "velocities", "effort": "effort"}


class NoNames(Exception):
    """A message that names no joints, where the scenario does not name them either."""


class ControllerStates(JointMessages):
    """What controllers measure, or ask for. Some releases have the fields of both names and fill one."""

    def __init__(self, joints: tuple[str, ...], parts: tuple[str, ...]) -> None:
        super().__init__(joints, Layout("joint_names", POINT))
        self._parts = parts

    def read(self, message: Any) -> tuple[tuple[str, ...], dict[str, Any]]:
        found = [point for name in self._parts if (point := getattr(message, name, None)) is not None]
        if not found:
            raise AttributeError(f"the message has none of {', '.join(self._parts)}")
        point = next((p for p in found if any(len(getattr(p, field)) for field in POINT.values())), found[0])
        return tuple(message.joint_names), {signal: getattr(point, field) for signal, field in POINT.items()}


class DynamicStates(JointMessages):
    """States whose interfaces are named joint by joint: position, velocity and effort of them."""

    def __init__(self, joints: tuple[str, ...]) -> None:
        super().__init__(joints, Layout("joint_names", {signal: signal for signal in POINT}))

    def read(self, message: Any) -> tuple[tuple[str, ...], dict[str, Any]]:
        rows = [
            dict(zip(each.interface_names, each.values, strict=False))
            for each in message.interface_values
        ]  # fmt: skip
        return tuple(message.joint_names), {signal: [row.get(signal, np.nan) for row in rows] for signal in POINT}


def collector_of(
    kind: str,
    fields: tuple[str, ...],
    joints: tuple[str, ...],
    *,
    role: str,
    stream: Stream | None = None,
    given: tuple[str, ...] = (),
    signal: str = "position",
) -> JointMessages | Trajectories | None:
    """What takes the messages of a joint topic; None for a type that has no joint values.

    Args:
        kind: the message type.
        fields: its field names.
        joints: the robot's joints.
        role: state, command or effort.
        stream: the fields as the scenario names them, for other messages than the known ones.
        given: the joints' names as the scenario states them, for messages that name none.
        signal: what the values of a message without names are.

    Raises:
        NoNames: for a message that names no joints, where `given` is empty.
    """
    if stream is not None and (stream.names or stream.position or stream.velocity or stream.effort):
        chosen = {"position": stream.position, "velocity": stream.velocity, "effort": stream.effort}
        names = None if given and stream.names is None else stream.names or "name"
        paths = {k: v for k, v in chosen.items() if v is not None}
        return JointMessages(joints, Layout(names, paths, given))
    if kind in ARRAYS:
        if not given:
            raise NoNames
        return JointMessages(joints, Layout(None, {signal: "data"}, given))
    if kind == TRAJECTORY:
        return Trajectories(joints) if role == "command" else None
    if kind.endswith("JointTrajectoryControllerState"):
        parts = ASKED if role == "command" else MEASURED
        return ControllerStates(joints, parts) if any(p in fields for p in parts) else None
    if kind == DYNAMIC_STATE:
        return DynamicStates(joints)
    layout = layout_of(fields)
    return None if layout is None else JointMessages(joints, layout)
