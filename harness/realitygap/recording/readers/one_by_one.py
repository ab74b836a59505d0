"""Commands that come in a topic for every joint, as ROS 1 and ros_control send them: std_msgs/Float64 and its like."""

from collections.abc import Mapping, Sequence
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from realitygap.files.errors import InputError
from realitygap.recording.readers.messages import JointMessages, Layout
from realitygap.recording.streams import Request
from realitygap.scenario.joint_names import JOINT
from realitygap.trace.trace import Array

KEY = "motion.recorded"
SINGLE = ("std_msgs/msg/Float64", "std_msgs/msg/Float32")
"""Messages of one number."""
Rows = NDArray[np.intp]


class SingleValues(JointMessages):
    """The messages of a topic that holds one value of one joint, alone or as an array of one."""

    def __init__(self, joints: tuple[str, ...], joint: str, signal: str) -> None:
        super().__init__(joints, Layout(None, {signal: "data"}, (joint,)))

    def read(self, message: Any) -> tuple[tuple[str, ...], dict[str, Any]]:
        names, values = super().read(message)
        return names, {signal: np.atleast_1d(value) for signal, value in values.items()}


def topics_asked(request: Request) -> dict[str, int]:
    """The topics of commands that hold one joint each, and the numbers of these joints; none where one holds all."""
    stated = None if request.motion is None else request.motion.recorded
    return topics_of(stated, request.joints, request.file) if isinstance(stated, dict) and request.joints else {}


def topics_of(stated: Mapping[str, str], joints: Sequence[str], file: Path) -> dict[str, int]:
    """Topics and the joint that each commands; a joint that no pattern matches is not commanded.

    Args:
        stated: topics by patterns over joint names, the first that matches; `*` in a topic is the joint's own name.
        joints: the robot's.
        file: the scenario file, for messages.

    Raises:
        InputError: for a pattern that matches no joint, or a topic that two joints get.
    """
    for pattern in stated:
        if not any(fnmatchcase(joint, pattern) for joint in joints):
            raise InputError(f"{file}: {KEY}: {pattern} matches no joint; the robot has {', '.join(joints)}")
    out: dict[str, int] = {}
    for j, joint in enumerate(joints):
        own = next((stated[p].replace(JOINT, joint) for p in stated if fnmatchcase(joint, p)), None)
        if own is not None and out.setdefault(own, j) != j:
            raise InputError(
                f"{file}: {KEY}: gives {joints[out[own]]} and {joint} the same topic {own}; expected another for each "
                "(`*` in it stands for the joint's own name), or the topic alone where its messages hold all joints"
            )
    return out


def together(
    topics: Sequence[tuple[JointMessages, Sequence[tuple[Array, Array, Rows]]]], signal: str
) -> tuple[dict[str, Array], NDArray[np.bool_], list[tuple[Array, Array, Rows]]]:
    """The messages of several topics as if they were those of one: values (m, n), which joints they name (m, n), and
    the parts of each with the numbers that its messages have among all.
    """
    values, present, moved = list[Array](), list[NDArray[np.bool_]](), list[tuple[Array, Array, Rows]]()
    for collector, own in topics:
        before = sum(len(each) for each in present)
        named = collector.named
        value, _ = collector.arrays()
        values.append(value.get(signal, np.full(named.shape, np.nan)))
        present.append(named)
        moved += [(time, received, rows + before) for time, received, rows in own]
    return {signal: np.concatenate(values)}, np.concatenate(present), moved
