"""Commands that are trajectories: what a controller makes of trajectory_msgs/JointTrajectory."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BPoly, CubicHermiteSpline

from realitygap.recording.readers.messages import Refused
from realitygap.recording.streams import Samples
from realitygap.trace.trace import Array

STEP = 0.005
"""How often a trajectory is sampled [s]: controllers run at 100 to 1000 Hz."""
Curve = Callable[[Array], Array]


@dataclass(frozen=True)
class _Goal:
    """The points of one message for one joint: times from its start (k,) [s], and the values there (k,)."""

    after: Array
    position: Array
    velocity: Array | None
    acceleration: Array | None


class Trajectories:
    """Trajectories as a joint trajectory controller follows them.

    From what was asked for at a trajectory's start (at the first: the measured position) through its points: linear
    where they have positions, cubic with velocities, quintic with accelerations too (ros2_controllers, "splines"). A
    new trajectory replaces the rest of an old one, and the last point holds.
    """

    def __init__(self, joints: tuple[str, ...]) -> None:
        self.joints = joints
        self.note = ""
        self._goals: list[dict[int, _Goal]] = []
        self.other: set[str] = set()

    def take(self, message: Any) -> bool:
        """Keep a trajectory; False where it names none of the joints or has no points, as one that stops."""
        names = list(message.joint_names)
        own = {self.joints.index(name): k for k, name in enumerate(names) if name in self.joints}
        if not own or not message.points:
            self.other.update(names)
            return False
        points = message.points
        after = np.array([p.time_from_start.sec + 1e-9 * p.time_from_start.nanosec for p in points])
        if (np.diff(after) <= 0).any():
            raise Refused("has points whose time_from_start does not increase")
        position = _values(points, "positions", len(names))
        if position is None:
            raise Refused("has points without positions; expected a trajectory of positions")
        velocity, acceleration = (_values(points, name, len(names)) for name in ("velocities", "accelerations"))
        self._goals.append(
            {
                joint: _Goal(
                    after,
                    position[:, k],
                    None if velocity is None else velocity[:, k],
                    None if velocity is None or acceleration is None else acceleration[:, k],
                )
                for joint, k in own.items()
            }
        )
        return True

    @property
    def nothing(self) -> str:
        """Why nothing was kept."""
        if not self.other:
            return "holds no messages"
        wanted = ", ".join(self.joints)
        return f"has no trajectory of {wanted}; it has {', '.join(sorted(self.other))}"

    def sampled(
        self, start: Array, keep: NDArray[np.int64], measured: Callable[[int, float], float] | None, end: float
    ) -> tuple[Array, Array]:
        """What was asked for over time.

        Args:
            start: Shape (m,), when each trajectory starts [s].
            keep: Shape (m,), which messages these are.
            measured: the position of a joint at a time; None where it is not known.
            end: of the recording [s].

        Returns:
            Times (k,) [s] and positions (k, n), NaN for a joint before its first trajectory.
        """
        curves: list[Curve] = [_nothing] * len(self.joints)
        times, values = [], []
        for i, (begin, number) in enumerate(zip(start, keep, strict=True)):
            goals = self._goals[number]
            for j, goal in goals.items():
                here = np.nan if measured is None else measured(j, float(begin))
                curves[j] = _curve(goal, float(begin), curves[j], here)
            last = begin + max(goal.after[-1] for goal in goals.values())
            stop = start[i + 1] if i + 1 < len(start) else max(end, last + STEP)
            grid = begin + STEP * np.arange(max(1, int(np.ceil((stop - begin) / STEP - 1e-6))))
            times.append(grid)
            values.append(np.column_stack([curve(grid) for curve in curves]))
        return np.concatenate(times), np.concatenate(values)


def followed(
    source: str,
    joints: tuple[str, ...],
    collector: Trajectories,
    time: Array,
    keep: NDArray[np.int64],
    state: Samples | None,
) -> Samples:
    """The commands that a controller makes of trajectories."""
    measured = None
    if state is not None and "position" in state.signals:
        clock, position = state.time, state.signals["position"]

        def measured(joint: int, at: float) -> float:
            known = np.isfinite(position[:, joint])
            return float(np.interp(at, clock[known], position[known, joint])) if known.any() else np.nan

    end = float(time[-1] if state is None else state.time[-1])
    times, values = collector.sampled(time, keep, measured, end)
    return Samples(source, times, {"position": values}, joints)


def _values(points: list[Any], field: str, count: int) -> Array | None:
    """A field of all points (k, n); None where some lack it."""
    rows = [getattr(point, field) for point in points]
    if any(len(row) == 0 for row in rows):
        return None
    if any(len(row) != count for row in rows):
        raise Refused(f"names {count} joints and holds another number of {field}")
    return np.array(rows, dtype=float)


def _nothing(time: Array) -> Array:
    return np.full(len(time), np.nan)


def _curve(goal: _Goal, begin: float, before: Curve, measured: float) -> Curve:
    """The positions that a controller asks for from the begin of a trajectory on."""
    times, position = begin + goal.after, goal.position
    velocity, acceleration = goal.velocity, goal.acceleration
    if goal.after[0] > 0:
        here = float(before(np.array([begin]))[0])
        first = here if np.isfinite(here) else measured if np.isfinite(measured) else float(position[0])
        slope = (here - float(before(np.array([begin - STEP]))[0])) / STEP
        times, position = np.append(begin, times), np.append(first, position)
        velocity = None if velocity is None else np.append(slope if np.isfinite(slope) else 0.0, velocity)
        acceleration = None if acceleration is None else np.append(0.0, acceleration)
    if len(times) == 1 or velocity is None:
        return lambda time: np.asarray(np.interp(time, times, position))
    if acceleration is None:
        cubic = CubicHermiteSpline(times, position, velocity)
        return lambda time: np.asarray(cubic(np.clip(time, times[0], times[-1])))
    quintic = BPoly.from_derivatives(times, np.column_stack([position, velocity, acceleration]))
    return lambda time: np.asarray(quintic(np.clip(time, times[0], times[-1])))
