"""What a bag holds, before any scenario says what is what."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from operator import attrgetter
from pathlib import Path

import numpy as np

from realitygap.recording.readers.messages import POSES, JointMessages, Layout, layout_of
from realitygap.recording.readers.rosbag import Bag, opened, short
from realitygap.trace.trace import Array


@dataclass(frozen=True)
class JointStream:
    """A stream of joint values: `signals` (m, n) that hold numbers other than 0, at `time` (m,) [s].

    `controller` is a stream that holds both what was asked for and what was measured.
    """

    topic: str
    kind: str
    joints: tuple[str, ...]
    time: Array
    signals: dict[str, Array]
    controller: bool = False


@dataclass(frozen=True)
class Contents:
    """What is in a bag, by what it can serve as; `kinds` are the types of all its topics."""

    path: Path
    listing: str
    joint_streams: list[JointStream] = field(default_factory=list)
    poses: list[str] = field(default_factory=list)
    imus: list[str] = field(default_factory=list)
    batteries: list[str] = field(default_factory=list)
    kinds: dict[str, str] = field(default_factory=dict)


def probe(path: Path, joints: Sequence[str]) -> Contents:
    """What a bag holds of these joints and of the base.

    Raises:
        InputError: for a recording that cannot be read.
    """
    with opened(path) as bag:
        layouts = {t: layout for t, kind in bag.types.items() if (layout := layout_of(kind, bag.fields(kind)))}
        kinds = {topic: short(kind) for topic, kind in bag.types.items()}
        return Contents(
            path,
            bag.listing(),
            [s for topic, layout in sorted(layouts.items()) if (s := _stream(bag, topic, layout, joints)) is not None],
            sorted(t for t, kind in bag.types.items() if kind in POSES),
            sorted(t for t, kind in kinds.items() if kind == "sensor_msgs/Imu"),
            sorted(t for t, kind in kinds.items() if kind == "sensor_msgs/BatteryState"),
            kinds,
        )


def _stream(bag: Bag, topic: str, layout: Layout, joints: Sequence[str]) -> JointStream | None:
    """The joint values of a topic; None where it names none of the joints, then told by `listing` alone."""
    names = attrgetter(layout.names)
    collector: JointMessages | None = None
    times = []
    for _, receive, message in bag.messages({topic}):
        if collector is None:
            found = tuple(joint for joint in joints if joint in set(names(message)))
            collector = JointMessages(found, layout, partial=True)
        if collector.joints and collector.take(message):
            times.append(receive * 1e-9)
    if collector is None or not times:
        return None
    signals, _ = collector.arrays()
    kept = {name: value for name, value in signals.items() if np.nan_to_num(value).any() or name == "position"}
    controller = bag.types[topic].endswith("JointTrajectoryControllerState")
    return JointStream(topic, short(bag.types[topic]), collector.joints, np.array(times), kept, controller)
