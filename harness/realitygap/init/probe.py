"""What a bag holds, before any scenario says what is what."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from realitygap.recording.readers.messages import NAMES, POSES
from realitygap.recording.readers.ros_control import ARRAYS, collector_of
from realitygap.recording.readers.rosbag import Bag, opened, short, told
from realitygap.recording.readers.trajectory import Trajectories
from realitygap.trace.trace import Array


@dataclass(frozen=True)
class JointStream:
    """A stream of joint values: `signals` (m, n) that hold numbers other than 0, at `time` (m,) [s].

    `controller` is a stream that holds both what was asked for and what was measured, `goal` one whose type says that
    it is a command. `joints` are empty where the messages name none; values are then as many as they hold.
    """

    topic: str
    kind: str
    joints: tuple[str, ...]
    time: Array
    signals: dict[str, Array]
    controller: bool = False
    goal: bool = False


@dataclass(frozen=True)
class Contents:
    """What is in a bag, by what it can serve as; `kinds` are the types of all its topics, `unnamed` the streams of
    values whose joints no message names, `others` the names in topics that name none of the robot's joints.
    """

    path: Path
    listing: str
    joint_streams: list[JointStream] = field(default_factory=list)
    unnamed: list[JointStream] = field(default_factory=list)
    poses: list[str] = field(default_factory=list)
    imus: list[str] = field(default_factory=list)
    batteries: list[str] = field(default_factory=list)
    kinds: dict[str, str] = field(default_factory=dict)
    others: dict[str, list[str]] = field(default_factory=dict)


def probe(path: Path, joints: Sequence[str]) -> Contents:
    """What a bag holds of these joints and of the base.

    Raises:
        InputError: for a recording that cannot be read.
    """
    with opened(path) as bag:
        kinds = {topic: short(kind) for topic, kind in bag.types.items()}
        return Contents(
            path,
            bag.listing(),
            [found for topic in sorted(bag.types) if (found := _named(bag, topic, joints)) is not None],
            [found for topic in sorted(bag.types) if (found := _unnamed(bag, topic)) is not None],
            sorted(t for t, kind in bag.types.items() if kind in POSES),
            sorted(t for t, kind in kinds.items() if kind == "sensor_msgs/Imu"),
            sorted(t for t, kind in kinds.items() if kind == "sensor_msgs/BatteryState"),
            kinds,
            {t: sorted(names) for t in sorted(bag.types) if (names := _names(bag, t)) and not names & {*joints}},
        )


def _names(bag: Bag, topic: str) -> set[str]:
    """The joints that the first message of a topic names."""
    fields = bag.fields(bag.types[topic])
    names = next((name for name in NAMES if name in fields), None)
    first = None if names is None else next(bag.messages({topic}), None)
    return set() if first is None or names is None else set(getattr(first[2], names))


def _named(bag: Bag, topic: str, joints: Sequence[str]) -> JointStream | None:
    """The joint values of a topic; None where it names none of the joints, then told by `listing` alone."""
    kind, fields = bag.types[topic], bag.fields(bag.types[topic])
    controller = kind.endswith("JointTrajectoryControllerState")
    there = _names(bag, topic)
    found = tuple(joint for joint in joints if joint in there)
    if not found:
        return None
    collector = collector_of(kind, fields, found, role="state" if controller else "command")
    if collector is None:
        return None
    taking = bag.taking(collector)
    with told(bag.path, topic):
        for _, receive, data, own in bag.raw({topic}):
            taking.take(receive, data, own)
        taking.finish()
    if not taking.received:
        return None
    time = np.array(taking.received) * 1e-9
    if isinstance(collector, Trajectories):
        time, position = collector.sampled(time, np.arange(len(time)), None, time[-1])
        return JointStream(topic, short(kind), collector.joints, time, {"position": position}, goal=True)
    signals, _ = collector.arrays()
    kept = {name: value for name, value in signals.items() if np.nan_to_num(value).any() or name == "position"}
    return JointStream(topic, short(kind), collector.joints, time, kept, controller)


def _unnamed(bag: Bag, topic: str) -> JointStream | None:
    """The values of a topic whose messages name no joints, as many in each; None for other topics."""
    if bag.types[topic] not in ARRAYS:
        return None
    found = [(receive * 1e-9, message.data) for _, receive, message in bag.messages({topic})]
    if not found or len({len(data) for _, data in found}) > 1 or not len(found[0][1]):
        return None
    time, rows = zip(*found, strict=True)
    return JointStream(topic, short(bag.types[topic]), (), np.array(time), {"position": np.array(rows, dtype=float)})
