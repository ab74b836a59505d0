"""A motion over time, simulated or measured: the same type for both."""

from collections.abc import Collection
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import pandas as pd

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Trace:
    """Joint and base signals on one clock. Angles in rad, SI units; a signal that was not recorded is None.

    Attributes:
        time: Shape (t,), strictly increasing [s].
        joints: n joint names, the order of all joint columns.
        position: Shape (t, n) [rad or m].
        velocity: Shape (t, n) [rad/s or m/s].
        effort: Shape (t, n) [N·m or N]: of the motor before friction, or of the joint, as the scenario says.
        command: Shape (t, n); NaN where no command was in force (the servo then gives no torque).
        base_position: Shape (t, 3) [m], world.
        base_quaternion: Shape (t, 4), w x y z.
        base_linear: Shape (t, 3) [m/s], world axes, of the base link's origin.
        base_angular: Shape (t, 3) [rad/s], world axes.
        imu_angular: Shape (t, 3) [rad/s], axes of the sensor.
        imu_quaternion: Shape (t, 4), w x y z.
        supply: Shape (t,) [V].
        effort_error: Shape (t, n), standard error of the effort [N·m or N], where that was estimated.
        temperature: Shape (t, n), of the joints' motors [°C].
        load: Shape (t, n), what gravity and inertia ask of the joint [N·m or N], where that was worked out.
    """

    time: Array
    joints: tuple[str, ...]
    position: Array | None = None
    velocity: Array | None = None
    effort: Array | None = None
    command: Array | None = None
    base_position: Array | None = None
    base_quaternion: Array | None = None
    base_linear: Array | None = None
    base_angular: Array | None = None
    imu_angular: Array | None = None
    imu_quaternion: Array | None = None
    supply: Array | None = None
    effort_error: Array | None = None
    load: Array | None = None
    temperature: Array | None = None
    notes: tuple[str, ...] = field(default=())

    SIGNALS = (
        "position",
        "velocity",
        "effort",
        "command",
        "base_position",
        "base_quaternion",
        "base_linear",
        "base_angular",
        "imu_angular",
        "imu_quaternion",
        "supply",
        "effort_error",
        "load",
        "temperature",
    )

    def __repr__(self) -> str:
        there = [s for s in self.SIGNALS if getattr(self, s) is not None]
        span = f"{self.time[0]:.3f} to {self.time[-1]:.3f} s, " if len(self.time) else ""
        joints = ", ".join(self.joints) if len(self.joints) <= 3 else f"{len(self.joints)} joints"
        return f"<Trace {span}{len(self.time)} samples of {joints or 'a body'}: {', '.join(there)}>"

    def to_frame(self) -> "pd.DataFrame":
        """The trace as a table: `frame["position"]["elbow"]` or `frame["position", "elbow"]` is a joint's position.

        Rows are samples, indexed by `time` [s]; columns have two levels, `signal` and `joint`, in SI units as here. In
        place of a joint's name stands x, y, z (w, x, y, z) for a signal of base or IMU and nothing for the supply.
        Signals that were not recorded have no columns.
        """
        from realitygap.trace.frame import to_frame

        return to_frame(self)

    def index(self, joint: str) -> int:
        """The column of a joint. Raises ValueError for a joint that is not in the trace."""
        return self.joints.index(joint)

    def between(self, start: float, end: float) -> "Trace":
        """The part with start <= time <= end, on the same clock."""
        keep = (self.time >= start) & (self.time <= end)
        return self.rows(keep)

    def only(self, signals: Collection[str]) -> "Trace":
        """The trace without its other signals."""
        others: dict[str, Any] = {name: None for name in self.SIGNALS if name not in signals}
        return replace(self, **others)

    def same_as(self, other: "Trace") -> bool:
        """Whether all times and signals are those of another trace, number by number."""
        pairs = [(self.time, other.time), *((getattr(self, s), getattr(other, s)) for s in self.SIGNALS)]
        return all(
            x is y is None or (x is not None and y is not None and np.array_equal(x, y, equal_nan=True))
            for x, y in pairs
        )

    def rows(self, keep: NDArray[np.bool_] | NDArray[np.int64]) -> "Trace":
        """The samples chosen by a mask or an index array; with all of them, this trace itself."""
        if keep.dtype == bool and keep.all():
            return self
        chosen: dict[str, Any] = {n: None if (v := getattr(self, n)) is None else v[keep] for n in self.SIGNALS}
        return replace(self, time=self.time[keep], **chosen)

    def at(self, time: Array) -> "Trace":
        """Every signal but the command interpolated linearly to other times; the command is the last one in force."""
        if time is self.time:
            return self
        out: dict[str, Any] = {}
        for name in self.SIGNALS:
            value = getattr(self, name)
            if value is None:
                out[name] = None
            elif name == "command":
                last = np.searchsorted(self.time, time, side="right") - 1
                out[name] = value[np.clip(last, 0, len(self.time) - 1)]
            elif value.ndim == 1:
                out[name] = np.interp(time, self.time, value)
            else:
                columns = [np.interp(time, self.time, column) for column in value.T]
                out[name] = np.column_stack(columns) if columns else np.zeros((len(time), 0))
        for name in ("base_quaternion", "imu_quaternion"):
            q = out[name]
            if q is not None:  # linear interpolation of close unit quaternions, put back on the sphere
                out[name] = q / np.linalg.norm(q, axis=1, keepdims=True)
        return replace(self, time=time, **out)
