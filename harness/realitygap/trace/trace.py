"""A motion over time, simulated or measured: the same type for both."""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

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
    )

    def index(self, joint: str) -> int:
        """The column of a joint. Raises ValueError for a joint that is not in the trace."""
        return self.joints.index(joint)

    def between(self, start: float, end: float) -> "Trace":
        """The part with start <= time <= end, on the same clock."""
        keep = (self.time >= start) & (self.time <= end)
        return self.rows(keep)

    def rows(self, keep: NDArray[np.bool_] | NDArray[np.int64]) -> "Trace":
        """The samples chosen by a mask or an index array."""
        chosen: dict[str, Any] = {n: None if (v := getattr(self, n)) is None else v[keep] for n in self.SIGNALS}
        return replace(self, time=self.time[keep], **chosen)

    def at(self, time: Array) -> "Trace":
        """Every signal but the command interpolated linearly to other times; the command is the last one in force."""
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
