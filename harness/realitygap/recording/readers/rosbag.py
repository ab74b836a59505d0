"""Rosbag 1 and rosbag 2 (MCAP, SQLite; a folder or a bare file), through the `rosbags` library."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray
from realitygap_engines.errors import in_a_line
from rosbags.highlevel import AnyReader
from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_typestore

from realitygap.files.errors import InputError
from realitygap.files.unpacked import unpacked
from realitygap.recording.lack import Lack
from realitygap.recording.readers.alike import Taking
from realitygap.recording.readers.bag_limits import Allowance, limited
from realitygap.recording.readers.clock import Clock, Nanoseconds, choose_clock
from realitygap.recording.readers.kind import check_kind
from realitygap.recording.readers.kinds import Kind, in_order, kinds_of, told_kinds
from realitygap.recording.readers.messages import BodyMessages, JointMessages, Reading, Refused, body_of, holds_joints
from realitygap.recording.readers.one_by_one import KEY, SINGLE, SingleValues, together, topics_asked
from realitygap.recording.readers.ros_control import ARRAYS, NoNames, collector_of
from realitygap.recording.readers.storage import storage_of
from realitygap.recording.readers.trajectory import Trajectories, followed
from realitygap.recording.readers.units import as_commanded, in_si
from realitygap.recording.streams import Request, Streams
from realitygap.scenario import schema as scenario
from realitygap.scenario.joint_names import hint
from realitygap.trace.trace import Array

Found = TypeVar("Found")
Collector = JointMessages | Trajectories | BodyMessages | Reading
Part = tuple[Array, Array, NDArray[np.intp]]
"""Times and times of reception [s] of messages (k,), and which of their topic these are (k,)."""
JOINT_ROLES = {"state": "recordings.state.joints", "command": "motion.joints", "effort": "recordings.effort.joints"}
"""Streams of joint values, and the key that names their joints where the messages do not."""
FARTHEST = 2**63
"""ns: times that are kept are smaller, either way."""
MAKE_WHOLE = "`rosbag reindex` (rosbag 1), `ros2 bag reindex` or `mcap recover` (rosbag 2)"


@dataclass(frozen=True)
class _Topic:
    """One topic while it is read, and what it serves as."""

    name: str
    role: str
    taking: Taking
    collector: Collector


def read(path: Path, request: Request) -> Streams:
    """The streams of a bag that a scenario asks for.

    Raises:
        InputError: for a bag that is empty or cut off, a topic that is not there or has another type, a message
            without the joints, or values that make no sense.
    """
    with opened(path) as bag:
        topics = []
        for role, name, key in _asked(bag, path, request):
            collector = _collector(bag, path, role, name, key, request)
            topics.append(_Topic(name, role, bag.taking(collector), collector))
        by_name: dict[str, list[_Topic]] = {}
        for topic in topics:
            by_name.setdefault(topic.name, []).append(topic)
        for name, receive, data, kind in bag.raw(set(by_name)):
            for topic in by_name[name]:
                with told(path, name):
                    topic.taking.take(receive, data, kind)
        for topic in topics:
            with told(path, topic.name):
                topic.taking.finish()
    single = [topic for topic in topics if isinstance(topic.collector, SingleValues)]
    silent = [topic for topic in single if not topic.taking.received]  # of joints that were not commanded
    topics = [topic for topic in topics if topic not in silent or len(silent) == len(single)]
    for topic in topics:
        _check_there(path, topic, request)
    clock, kinds = _clock(topics, request)
    roles: dict[str, Any] = {}
    notes, dropped = [clock.note], [Lack("clock", clock.note, 1.0)] if clock.by_reception else []
    one_by_one: list[tuple[JointMessages, list[Part]]] = []
    for topic in topics:
        source, parts = f"{path}: {topic.name}", list[Part]()
        for own in kinds[topic.name]:
            time, received, keep, mended = clock.times(own.name)
            if mended is not None:
                dropped.append(replace(mended, text=f"{own.name}: {mended.text}"))
            parts.append((time, received, own.rows[keep]))
        if isinstance(topic.collector, Trajectories):
            (time, _, keep), *_ = parts
            measured = None if "state" not in roles else as_commanded(roles["state"], request)
            roles[topic.role] = followed(source, request.joints, topic.collector, time, keep, measured)
            continue
        if isinstance(topic.collector, SingleValues):
            one_by_one.append((topic.collector, parts))
            continue
        joints = request.joints if isinstance(topic.collector, JointMessages) else ()
        roles[topic.role] = in_order(source, joints, *topic.collector.arrays(), parts)
        notes += [f"{topic.name}: {told}" for told in (topic.collector.note, told_kinds(kinds[topic.name])) if told]
    if one_by_one:
        source, joined = f"{path}: commands by joint", together(one_by_one, request.command_signal)
        roles["command"] = in_order(source, request.joints, *joined)
    roles = {role: in_si(samples, role, request) for role, samples in roles.items()}
    return Streams(**roles, notes=tuple(dict.fromkeys(notes)), dropped=tuple(dict.fromkeys(dropped)))


def _check_there(path: Path, topic: _Topic, request: Request) -> None:
    """Make sure that a topic holds messages, and that its measured joints are all of those that are asked for."""
    collector = topic.collector
    if not topic.taking.received:
        others = collector.other if isinstance(collector, JointMessages | Trajectories) else ()
        expected = f"; expected names as in the URDF, or {hint(others, request.joints)}" if others else ""
        raise InputError(f"{path}: {topic.name}: {collector.nothing}{expected}")
    if topic.role != "command" and isinstance(collector, JointMessages) and collector.lacking:
        raise InputError(f"{path}: {topic.name}: {collector.lacking}")


def _clock(topics: list[_Topic], request: Request) -> tuple[Clock, dict[str, list[Kind]]]:
    """The clock of all messages, of which those of one topic that name other joints are stamped by another publisher;
    and the kinds of messages of every topic.
    """
    kinds, stamps = dict[str, list[Kind]](), dict[str, tuple[Nanoseconds, Nanoseconds]]()
    for topic in topics:
        own = np.array(topic.taking.stamps), np.array(topic.taking.received)
        named = topic.collector.present if isinstance(topic.collector, JointMessages) else None
        kinds[topic.name] = kinds_of(topic.name, request.joints, named, len(own[0]))
        stamps |= {kind.name: (own[0][kind.rows], own[1][kind.rows]) for kind in kinds[topic.name]}
    return choose_clock(stamps), kinds


def _asked(bag: "Bag", path: Path, request: Request) -> list[tuple[str, str, str]]:
    """Role, topic and scenario key of every stream that is asked for."""
    recordings = request.recordings
    state = recordings.state.topic if isinstance(recordings.state, scenario.Stream) else recordings.state
    if state is None and request.joints:
        raise InputError(
            f"{request.file}: recordings.state: is missing; expected the topic of the joint states in {path}; it has "
            f"{bag.listing()}"
        )
    recorded = request.motion.recorded if request.motion and request.joints else None
    commands = [recorded] if isinstance(recorded, str) else [*topics_asked(request)]
    asked = [
        ("state", state if request.joints else None, "recordings.state"),
        *(("command", topic, KEY) for topic in commands),
        ("effort", request.effort_topic if request.joints else None, "recordings.effort.topic"),
        ("pose", recordings.pose, "recordings.pose"),
        ("imu", recordings.imu, "recordings.imu"),
        ("supply", request.supply, "supply"),
        ("temperature", recordings.temperature if request.joints else None, "recordings.temperature"),
    ]
    found = [(role, topic, key) for role, topic, key in asked if topic is not None]
    for _, topic, key in found:
        if topic not in bag.types:
            way = f'; a pattern is written as {{"*": "{topic}"}}' if key == KEY and "*" in topic else ""
            raise InputError(f"{request.file}: {key}: {path} has no topic {topic}; it has {bag.listing()}{way}")
    return found


def _collector(bag: "Bag", path: Path, role: str, topic: str, key: str, request: Request) -> Collector:
    """What takes the messages of a topic in a role."""
    kind = bag.types[topic]
    made: Collector | None
    expected = "a BatteryState"
    if role == "command" and topic in (by_joint := topics_asked(request)):
        own = SingleValues(request.names, request.names[by_joint[topic]], request.command_signal)
        made, expected = own if kind in (*SINGLE, *ARRAYS) else None, "a Float64 of one joint"
    elif role in JOINT_ROLES:
        made = _joint_collector(bag, path, role, topic, request)
        expected = (
            "a JointState, JointTrajectoryControllerState, DynamicJointState, Float64MultiArray or another message "
            "with arrays of names and values" + (", or a JointTrajectory" if role == "command" else "")
        )
    elif role == "supply":
        made = Reading("voltage", "supply") if "voltage" in bag.fields(kind) else None
    elif role == "temperature":
        made = Reading("temperature", "temperature") if "temperature" in bag.fields(kind) else None
        expected = "a sensor_msgs/Temperature"
    else:
        made = body_of(kind, imu=role == "imu")
        expected = "an Imu" if role == "imu" else "a PoseStamped or Odometry"
    if made is None:
        raise InputError(f"{request.file}: {key}: {topic} in {path} is a {short(kind)}; expected {expected}")
    return made


def _joint_collector(bag: "Bag", path: Path, role: str, topic: str, request: Request) -> Collector | None:
    """What takes the messages of a topic of joint values; None for a type that has none."""
    kind = bag.types[topic]
    named = dict(zip(request.joints, request.names, strict=True))
    asked = {"state": request.recordings.state, "command": request.motion, "effort": request.recordings.effort}[role]
    try:
        return collector_of(
            kind,
            bag.fields(kind),
            request.names,
            role=role,
            stream=asked if isinstance(asked, scenario.Stream) else None,
            given=tuple(named.get(joint, joint) for joint in getattr(asked, "joints", None) or ()),
            signal={"state": "position", "command": request.command_signal, "effort": "effort"}[role],
        )
    except NoNames:
        raise InputError(
            f"{request.file}: {JOINT_ROLES[role]}: is missing; {topic} in {path} is a {short(kind)}, which names no "
            f"joints; expected the joints of its values in their order, of {', '.join(request.joints)}"
        ) from None


def stamp_of(message: Any) -> int:
    """The header stamp [ns]; 0 where there is none."""
    header = getattr(message, "header", None)
    return 0 if header is None else int(header.stamp.sec) * 1_000_000_000 + int(header.stamp.nanosec)


def short(kind: str) -> str:
    """A message type as people write it: sensor_msgs/JointState."""
    return kind.replace("/msg/", "/")


class Bag:
    """An open bag: its topics with their types and counts, when it begins [ns], and its messages."""

    def __init__(self, path: Path, reader: AnyReader, limits: Allowance) -> None:
        self.path, self._limits = path, limits
        self.begin = int(reader.start_time)
        self._reader = reader
        self.types = {c.topic: c.msgtype for c in reader.connections}
        self._fixed: dict[str, int] = {}
        self.counts: dict[str, int] = {}
        for connection in reader.connections:
            self.counts[connection.topic] = self.counts.get(connection.topic, 0) + connection.msgcount

    def listing(self) -> str:
        """The topics with their types, for messages to the user."""
        return ", ".join(f"{t} ({short(k)})" for t, k in sorted(self.types.items())) or "no topics"

    def fields(self, kind: str) -> tuple[str, ...]:
        """The field names of a message type, without those that are called as joint values are and hold none."""
        definition = self._reader.typestore.fielddefs.get(kind)
        return () if definition is None else tuple(name for name, what in definition[1] if holds_joints(name, *what))

    def messages(self, topics: set[str]) -> Iterator[tuple[str, int, Any]]:
        """Topic, time of reception [ns] and message, in the order of reception."""
        for topic, receive, data, kind in self.raw(topics):
            yield topic, receive, self.deserialize(data, kind)

    def raw(self, topics: set[str]) -> Iterator[tuple[str, int, bytes, str]]:
        """The same with the bytes of the messages and their type."""
        chosen = [c for c in self._reader.connections if c.topic in topics]
        if not chosen:
            return
        self._limits.unpacked = 0  # it may be read again
        raw = self._reader.messages(connections=chosen)
        following = partial(next, raw, None)
        while (found := _reading(self.path, following)) is not None:
            connection, received, data = found
            if not (isinstance(received, int) and abs(received) < FARTHEST and isinstance(data, bytes)):
                raise InputError(
                    f"{self.path}: {connection.topic}: a message was received at {in_a_line(received, 40)} and holds "
                    f"{type(data).__name__}; expected a whole number of nanoseconds and bytes: record it again"
                )
            yield connection.topic, received, data, connection.msgtype

    def taking(self, collector: Collector) -> Taking:
        """What gives the messages of a topic to a collector."""
        return Taking(self, collector, stamp_of)

    def deserialize(self, data: bytes, kind: str) -> Any:
        """The message in bytes.

        Raises:
            InputError: for bytes that are no such message, or fewer than its fixed arrays have elements.
        """
        if len(data) < self._least(kind):
            raise InputError(
                f"{self.path}: a {short(kind)} of {len(data)} bytes was found; expected at least {self._least(kind)}, "
                "one for every element of its fixed arrays: record it again"
            )
        return _reading(self.path, partial(self._reader.deserialize, data, kind))

    def _least(self, kind: str) -> int:
        """How many bytes a message of a type has at least: one for every element of a fixed array."""
        if kind not in self._fixed:
            fields = [field for _, field in self._reader.typestore.fielddefs.get(kind, ((), ()))[1]]
            arrays = sum(int(what[1]) for node, what in fields if node == Nodetype.ARRAY)
            self._fixed[kind] = arrays  # of a type that holds itself, too
            self._fixed[kind] += sum(self._least(str(what)) for node, what in fields if node == Nodetype.NAME)
        return self._fixed[kind]

    def serialize(self, message: Any, kind: str) -> bytes:
        """The bytes of a message, as this bag's would be."""
        store = self._reader.typestore
        return bytes(store.serialize_cdr(message, kind) if self._reader.is2 else store.serialize_ros1(message, kind))


@contextmanager
def told(path: Path, topic: str) -> Iterator[None]:
    """Tell where a message that cannot be used stands."""
    try:
        yield
    except Refused as error:
        raise InputError(f"{path}: {topic}: {error}") from None


@contextmanager
def opened(path: Path) -> Iterator[Bag]:
    """A bag that is open for reading.

    Raises:
        InputError: for a bag that is empty or cannot be read.
    """
    store = get_typestore(Stores.LATEST)
    with unpacked(path) as plain, limited(plain) as limits:
        source = storage_of(plain)
        if source.is_file():
            _reading(path, partial(check_kind, path if source == plain else source, source))
        reader = _reading(path, lambda: AnyReader([source], default_typestore=store))
        _reading(path, reader.open)
        try:
            bag = Bag(path, reader, limits)
            if not sum(bag.counts.values()):
                raise InputError(f"{path}: the bag holds no messages; it has {bag.listing()}")
            yield bag
        finally:
            reader.close()


def _reading(path: Path, action: Callable[[], Found]) -> Found:
    """What the library returns; whatever it trips over in a broken file is a broken file."""
    try:
        return action()
    except InputError:
        raise
    except Exception as error:
        deep = isinstance(error, RecursionError)
        what = "nested too deeply" if deep else " ".join(str(error).split()) or type(error).__name__
        raise InputError(
            f"{path}: the bag cannot be read ({what}); expected a whole rosbag 1 or 2; one that was cut off is made "
            f"whole by {MAKE_WHOLE}"
        ) from None
