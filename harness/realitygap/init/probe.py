"""What a recording holds, before any scenario says what is what."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from operator import attrgetter
from pathlib import Path

import numpy as np

from realitygap.files.errors import InputError
from realitygap.recording import reader_of
from realitygap.recording.readers.messages import POSES, JointMessages, Layout, layout_of
from realitygap.recording.readers.rosbag import Bag, opened, short
from realitygap.recording.readers.table import FORMS, load
from realitygap.trace.trace import Array

COLUMN_NAMES = {  # what people call the columns of a table, the scenario's default first
    "time": ("time", "t", "timestamp", "stamp", "time_s"),
    "command": ("command", "cmd", "goal", "target", "desired", "reference", "setpoint"),
    "position": ("position", "pos", "q", "angle", "measured"),
    "velocity": ("velocity", "vel", "qd", "dq", "speed"),
    "effort": ("effort", "torque", "force", "tau"),
}


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
    """What is in a recording, by what it can serve as; `columns` for tables: scenario key to column name."""

    path: Path
    listing: str
    joint_streams: list[JointStream] = field(default_factory=list)
    poses: list[str] = field(default_factory=list)
    imus: list[str] = field(default_factory=list)
    batteries: list[str] = field(default_factory=list)
    columns: dict[str, str] | None = None


def probe(path: Path, joints: Sequence[str]) -> Contents:
    """What a recording holds of these joints and of the base.

    Raises:
        InputError: for a recording that cannot be read.
    """
    return _table(path, joints) if reader_of(path) == "table" else _bag(path, joints)


def _bag(path: Path, joints: Sequence[str]) -> Contents:
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


def _table(path: Path, joints: Sequence[str]) -> Contents:
    frame = load(path)
    listing = ", ".join(frame.columns)

    def there(stem: str) -> bool:
        forms = [[form.format(stem, joint) for form in FORMS] for joint in joints]
        alone = len(joints) == 1 and stem in frame
        return alone or (bool(joints) and all(any(name in frame for name in each) for each in forms))

    columns = {}
    for key, options in COLUMN_NAMES.items():
        found = next((name for name in options if (name in frame if key == "time" else there(name))), None)
        if found is not None:
            columns[key] = found
    if "time" not in columns:
        raise InputError(f"{path}: has no column of time; it has {listing}; expected one named time, in s")
    return Contents(path, listing, columns=columns)
