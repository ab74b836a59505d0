"""What a bag holds, before any scenario says what is what."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from realitygap.recording.merged import on_one_clock
from realitygap.recording.readers.alike import Taking
from realitygap.recording.readers.kinds import in_order, kinds_of
from realitygap.recording.readers.messages import NAMES, POSES, JointMessages
from realitygap.recording.readers.one_by_one import SINGLE
from realitygap.recording.readers.ros_control import ARRAYS, collector_of
from realitygap.recording.readers.rosbag import Bag, opened, short, told
from realitygap.recording.readers.trajectory import Trajectories
from realitygap.recording.streams import Samples
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
    values whose joints no message names, `single` those of one number, `others` the names in topics that name none of
    the robot's joints.
    """

    path: Path
    listing: str
    joint_streams: list[JointStream] = field(default_factory=list)
    unnamed: list[JointStream] = field(default_factory=list)
    single: list[JointStream] = field(default_factory=list)
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
        taken = {t: taking for t in sorted(bag.types) if (taking := _taken(bag, t, joints)) is not None}
        streams = {t: found for t, taking in taken.items() if (found := _named(bag, t, taking, joints)) is not None}
        return Contents(
            path,
            bag.listing(),
            list(streams.values()),
            _unnamed(bag, ARRAYS),
            _unnamed(bag, SINGLE),
            sorted(t for t, kind in bag.types.items() if kind in POSES),
            sorted(t for t, kind in kinds.items() if kind == "sensor_msgs/Imu"),
            sorted(t for t, kind in kinds.items() if kind == "sensor_msgs/BatteryState"),
            kinds,
            {t: sorted(names) for t, taking in taken.items() if (names := _others(taking))},
        )


def _taken(bag: Bag, topic: str, joints: Sequence[str]) -> Taking | None:
    """The messages of a topic that name joints, read as far as they name these; None for other topics."""
    kind, fields = bag.types[topic], bag.fields(bag.types[topic])
    if not joints or not any(name in fields for name in NAMES):
        return None
    collector = collector_of(kind, fields, tuple(joints), role="state" if _controls(kind) else "command")
    if collector is None:
        return None
    taking = bag.taking(collector)
    with told(bag.path, topic):
        for _, receive, data, own in bag.raw({topic}):
            taking.take(receive, data, own)
        taking.finish()
    return taking


def _named(bag: Bag, topic: str, taking: Taking, joints: Sequence[str]) -> JointStream | None:
    """The joint values of a topic, of the joints that it names; None where it names none of them."""
    if not taking.received:
        return None
    kind, collector = bag.types[topic], taking.collector
    time = np.array(taking.received) * 1e-9
    if isinstance(collector, Trajectories):
        time, position = collector.sampled(time, np.arange(len(time)), None, time[-1])
        present = np.isfinite(position)
        samples = Samples(topic, time, {"position": position})
    else:
        assert isinstance(collector, JointMessages)
        kinds = kinds_of(topic, joints, collector.present, len(time))
        parts = [(time[k.rows], time[k.rows], k.rows) for k in kinds]
        samples = in_order(topic, tuple(joints), *collector.arrays(), parts)
        present = np.ones((1, len(joints)), dtype=bool) if samples.present is None else samples.present
        samples, _ = on_one_clock(samples)
    there = [i for i in range(len(joints)) if present[:, i].any()]
    kept = {name: value[:, there] for name, value in samples.signals.items()}
    kept = {name: value for name, value in kept.items() if np.nan_to_num(value).any() or name == "position"}
    named, goal = tuple(joints[i] for i in there), isinstance(collector, Trajectories)
    return JointStream(topic, short(kind), named, samples.time, kept, _controls(kind), goal)


def _others(taking: Taking) -> set[str]:
    """The names in messages of which none names a joint."""
    collector = taking.collector
    return collector.other if isinstance(collector, JointMessages | Trajectories) and not taking.received else set()


def _controls(kind: str) -> bool:
    return kind.endswith("JointTrajectoryControllerState")


def _unnamed(bag: Bag, kinds: Sequence[str]) -> list[JointStream]:
    """The values of topics of some types whose messages name no joints, as many in each."""
    out = []
    for topic in sorted(topic for topic, kind in bag.types.items() if kind in kinds):
        found = [(receive * 1e-9, np.atleast_1d(message.data)) for _, receive, message in bag.messages({topic})]
        if found and len({len(data) for _, data in found}) == 1 and len(found[0][1]):
            time, rows = zip(*found, strict=True)
            values = {"position": np.array(rows, dtype=float)}
            out.append(JointStream(topic, short(bag.types[topic]), (), np.array(time), values))
    return out
