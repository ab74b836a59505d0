"""Taking the fields out of ROS messages, one topic at a time."""

from array import array
from dataclasses import dataclass
from operator import attrgetter
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rosbags.interfaces import Nodetype

from realitygap.files.found import counted
from realitygap.recording.frames import rotate, unit_quaternions
from realitygap.trace.trace import Array


class Refused(Exception):
    """A message that cannot be used, and why."""


@dataclass(frozen=True)
class Layout:
    """The fields of a message with joint arrays; dots go into nested messages. `names` None: they are `joints`."""

    names: str | None
    signals: dict[str, str]
    joints: tuple[str, ...] = ()


NOT_RECORDED = "expected all: a joint that was not recorded is welded by robot.hold"
NAMES = ("name", "names", "joint_names")
SIGNALS = {
    "position": ("position", "positions"),
    "velocity": ("velocity", "velocities"),
    "effort": ("effort", "efforts"),
}


def holds_joints(field: str, node: Nodetype, what: Any) -> bool:
    """Whether a field of a message is text or numbers, one or several, as its name says; any of another name is."""
    text, numbers = field in NAMES, any(field in options for options in SIGNALS.values())
    if not text and not numbers:
        return True
    if node in (Nodetype.ARRAY, Nodetype.SEQUENCE):
        node, what = what[0]
    return node == Nodetype.BASE and (what[0] == "string") == text


def layout_of(fields: tuple[str, ...]) -> Layout | None:
    """Where names and values stand in a message with such fields; None where it has no such arrays."""
    names = next((n for n in NAMES if n in fields), None)
    found = {signal: f for signal, options in SIGNALS.items() for f in options if f in fields}
    return Layout(names, found) if names and found else None


class JointMessages:
    """Messages with joint names and arrays, as in sensor_msgs/JointState, brought to one order of joints.

    A message that names none of the joints belongs to another publisher and is passed over; one may name some of them.
    `other` are the names in messages that were passed over.
    """

    def __init__(self, joints: tuple[str, ...], layout: Layout) -> None:
        self.joints = joints
        self.paths = layout.signals
        self._given = layout.joints
        self._names = None if layout.names is None else attrgetter(layout.names)
        self._getters = {signal: attrgetter(path) for signal, path in layout.signals.items()}
        # one long row each, as small ones scatter memory, and empty until a message holds numbers
        self._rows = {signal: array("d") for signal in layout.signals}
        self._kept = 0
        self._present: list[NDArray[np.bool_]] = []  # (k, n) each, as the rows
        self._orders: dict[tuple[str, ...], tuple[NDArray[np.intp], NDArray[np.bool_]]] = {}
        self.other: set[str] = set()
        self._passed = 0

    def take(self, message: Any) -> bool:
        """Keep what the message says of the joints; False where it names none of them."""
        try:
            names, values = self.read(message)
            rows = {signal: np.asarray(value, dtype=float)[None, :] for signal, value in values.items()}
        except AttributeError as error:
            raise Refused(f"{error}; expected the fields that recordings.state names") from None
        except (TypeError, ValueError, IndexError):
            held = ", ".join(self.paths.values())
            raise Refused(f"holds no array of numbers in {held}; expected fields with one for every joint") from None
        return self.take_many(names, rows, 1)

    def take_many(self, names: tuple[str, ...], values: dict[str, Array], count: int) -> bool:
        """Keep what messages with the same names say, values (count, m) by signal; False where they name no joint."""
        order, present = self._order(names)
        if not present.any():
            self.other.update(names)
            self._passed += count
            return False
        for signal, value in values.items():
            held = value.shape[1]
            gathered = self._rows[signal]
            if not gathered and held == 0:
                continue
            if not gathered:
                gathered.frombytes(np.full((self._kept, len(self.joints)), np.nan).tobytes())
            if held == 0:
                rows = np.broadcast_to(np.nan, (count, len(self.joints)))
            elif held == len(names):
                rows = value[:, order] if present.all() else np.where(present, value[:, order], np.nan)
            elif self._given:
                raise Refused(f"holds {counted(held, 'value')}, but {len(names)} joints are named: {', '.join(names)}")
            else:
                raise Refused(f"names {len(names)} joints and holds {held} values of {signal}")
            gathered.frombytes(np.asarray(rows, dtype=float).tobytes())
        self._kept += count
        self._present.append(np.broadcast_to(present, (count, len(self.joints))))
        return True

    @property
    def plain(self) -> bool:
        """Whether `read` takes the fields at `paths` and nothing else."""
        return type(self).read is JointMessages.read

    def read(self, message: Any) -> tuple[tuple[str, ...], dict[str, Any]]:
        """The names and the values of a message, signal by signal."""
        names = self._given if self._names is None else self._names(message)
        values = {signal: get(message) for signal, get in self._getters.items()}
        if isinstance(names, str):  # a message of one joint
            return (names,), {signal: np.atleast_1d(value) for signal, value in values.items()}
        return tuple(names), values

    def _order(self, names: tuple[str, ...]) -> tuple[NDArray[np.intp], NDArray[np.bool_]]:
        if names not in self._orders:
            where = {name: i for i, name in enumerate(names)}
            again = next((joint for joint in self.joints if names.count(joint) > 1), None)
            if again is not None:
                raise Refused(f"names joint {again} twice: {', '.join(names)}; expected every joint once")
            present = np.array([joint in where for joint in self.joints])
            order = np.array([where.get(joint, 0) for joint in self.joints], dtype=np.intp)
            self._orders[names] = order, present
        return self._orders[names]

    def arrays(self) -> tuple[dict[str, Array], NDArray[np.bool_] | None]:
        """The signals that hold numbers, each (m, n), and which joints the messages named (None: all).

        What was gathered is given away, signal by signal: a long recording is there once.
        """
        signals = {}
        for signal, gathered in self._rows.items():
            rows = np.frombuffer(gathered, dtype=float).reshape(-1, len(self.joints))
            if not np.isnan(rows).all():
                signals[signal] = rows
        self._rows = {signal: array("d") for signal in self._rows}
        return signals, self.present

    @property
    def present(self) -> NDArray[np.bool_] | None:
        """Which joints the messages named (m, n); None: all."""
        return None if all(part.all() for part in self._present) else self.named

    @property
    def named(self) -> NDArray[np.bool_]:
        """Which joints the messages named. Shape (m, n)."""
        return np.concatenate([np.zeros((0, len(self.joints)), dtype=bool), *self._present])

    @property
    def lacking(self) -> str:
        """Which joints no message names, where others are named; "" where there are none."""
        missing = [j for i, j in enumerate(self.joints) if not any(part[0, i] for part in self._present)]
        if not missing or len(missing) == len(self.joints):
            return ""
        own = [names for names, (_, present) in self._orders.items() if present.any()]
        found = dict.fromkeys(name for names in own for name in names)
        return (
            f"has no joint {', '.join(missing)}; it has {', '.join(found)}; {NOT_RECORDED}, and recordings.joints "
            "tells its name here"
        )

    @property
    def nothing(self) -> str:
        """Why nothing was kept."""
        wanted = ", ".join(self.joints)
        if not self._passed:
            return "holds no messages"
        return f"has no joint {wanted}; it has {', '.join(sorted(self.other)) or 'none'}"

    @property
    def note(self) -> str:
        """What was passed over."""
        return f"{self._passed} messages name other joints and were passed over" if self._passed else ""


POSES = {  # where pose and, if it has one, twist stand in a message type
    "geometry_msgs/msg/PoseStamped": ("pose", None),
    "geometry_msgs/msg/PoseWithCovarianceStamped": ("pose.pose", None),
    "nav_msgs/msg/Odometry": ("pose.pose", "twist.twist"),
}


def body_of(kind: str, *, imu: bool) -> "BodyMessages | None":
    """What takes the messages of a base pose or an IMU; None for other types."""
    if imu:
        return BodyMessages(None, None) if kind == "sensor_msgs/msg/Imu" else None
    return BodyMessages(*POSES[kind]) if kind in POSES else None


class BodyMessages:
    """Poses (with the twist, for odometry) of a base, or readings of an IMU where `pose` is None."""

    nothing = "holds no messages"
    note = ""

    def __init__(self, pose: str | None, twist: str | None) -> None:
        self._pose = attrgetter(pose) if pose else None
        self._twist = attrgetter(twist) if twist else None
        self._rows: list[list[float]] = []

    def take(self, message: Any) -> bool:
        """Keep the message."""
        if self._pose is None:
            w = message.angular_velocity
            # a covariance that starts with -1 says that there is no orientation (sensor_msgs/Imu)
            known = message.orientation_covariance[0] != -1.0
            self._rows.append([*_wxyz(message.orientation), w.x, w.y, w.z, float(known)])
            return True
        pose = self._pose(message)
        row = [*_wxyz(pose.orientation), pose.position.x, pose.position.y, pose.position.z]
        if self._twist is not None:
            v, w = (t := self._twist(message)).linear, t.angular
            row += [v.x, v.y, v.z, w.x, w.y, w.z]
        self._rows.append(row)
        return True

    def arrays(self) -> tuple[dict[str, Array], None]:
        """The signals by their names in a trace. The twist of an odometry is in its child frame, the base."""
        rows = np.array(self._rows, dtype=float)
        quaternion = rows[:, :4]
        if self._pose is None:
            signals = {"imu_angular": rows[:, 4:7]}
            if rows[:, 7].all() and quaternion.any(axis=1).all():
                signals["imu_quaternion"] = quaternion
            return signals, None
        signals = {"base_quaternion": quaternion, "base_position": rows[:, 4:7]}
        if self._twist is not None:
            unit = unit_quaternions(quaternion)
            signals["base_linear"] = rotate(unit, rows[:, 7:10])
            signals["base_angular"] = rotate(unit, rows[:, 10:13])
        return signals, None


class Reading:
    """One number of every message, as the voltage of a sensor_msgs/BatteryState: the field, and the signal it is."""

    nothing = "holds no messages"
    note = ""

    def __init__(self, field: str, signal: str) -> None:
        self._of, self._signal = attrgetter(field), signal
        self._values: list[float] = []

    def take(self, message: Any) -> bool:
        """Keep the message."""
        self._values.append(float(self._of(message)))
        return True

    def arrays(self) -> tuple[dict[str, Array], None]:
        """The readings (m,)."""
        return {self._signal: np.array(self._values)}, None


def _wxyz(q: Any) -> list[float]:
    return [q.w, q.x, q.y, q.z]
