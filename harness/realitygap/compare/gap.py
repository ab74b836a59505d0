"""How far simulation and measurement are apart, per joint and signal, beside the floors below which nothing counts."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from realitygap_engines.model.robot import axis_rotation, rotation_between

from realitygap.files.mapped import let_go
from realitygap.recording.delay import MOVING
from realitygap.recording.frames import angle_between, vertical
from realitygap.trace.trace import Array, Trace

MOVING_LINEAR = 5e-4
"""What `MOVING` is for prismatic joints [m]."""
JOINT_SIGNALS = ("position", "velocity", "effort")
BASE = {
    "base_position": ("base_position", "m", 1.0),
    "base_quaternion": ("base_orientation", "deg", 180 / np.pi),
    "base_angular": ("base_angular_velocity", "deg/s", 180 / np.pi),
}
"""What is compared of a moving base: what each signal is called in tables, its unit there, and the factor from SI."""


class NamedJoint(Protocol):
    """A joint as far as a difference needs it."""

    @property
    def name(self) -> str:
        """Its name."""

    @property
    def prismatic(self) -> bool:
        """Whether it slides, so that metres and newtons take the place of radians and newton metres."""


class Jointed(Protocol):
    """A robot model, or whatever else has joints in the order of a simulated trace's columns."""

    @property
    def joints(self) -> Sequence[NamedJoint]:
        """The joints."""


@dataclass(frozen=True)
class Difference:
    """The absolute difference of one signal over time: `values` in `unit`, of one joint or of the base.

    `scale` turns SI into the unit, for floors that are known in SI.
    """

    joint: str
    signal: str
    unit: str
    group: str
    scale: float
    values: Array


def unit_of(signal: str, prismatic: bool) -> tuple[str, float]:
    """The unit of a joint signal in tables for people, and its factor from SI."""
    if signal == "effort":
        return ("N", 1.0) if prismatic else ("N·m", 1.0)
    unit, factor = ("mm", 1e3) if prismatic else ("deg", 180 / np.pi)
    return (unit, factor) if signal == "position" else (f"{unit}/s", factor)


def moving_joints(model: Jointed, measured: Trace) -> list[bool]:
    """Which joints are commanded to move within a trace; without commands, which were measured to move."""
    source = measured.command
    if source is None or np.isnan(source).all():
        source = measured.position
    out = []
    for i, joint in enumerate(model.joints):
        column = np.zeros(1) if source is None else source[:, measured.index(joint.name)]
        column = column[np.isfinite(column)]
        reach = float(np.ptp(column)) if column.size else 0.0
        out.append(reach > (MOVING_LINEAR if model.joints[i].prismatic else MOVING))
    let_go(source)
    return out


def differences(model: Jointed, simulated: Trace, measured: Trace) -> Iterator[Difference]:
    """Simulated minus measured, absolute, at the measured time stamps, for every signal that both have, one by one.

    Samples that were not measured (NaN) are left out.
    """
    sim = simulated.at(measured.time)
    moves = moving_joints(model, measured)
    for signal in JOINT_SIGNALS:
        ours, theirs = getattr(sim, signal), getattr(measured, signal)
        if ours is None or theirs is None:
            continue
        for i, joint in enumerate(model.joints):
            unit, scale = unit_of(signal, joint.prismatic)
            delta = np.abs(ours[:, i] - theirs[:, measured.index(joint.name)])
            group = "moving" if moves[i] else "unmoving"
            yield Difference(joint.name, signal, unit, group, scale, delta[np.isfinite(delta)] * scale)
        let_go(theirs)  # of a long recording, one signal is as much as memory should hold
    yield from _base(sim, measured)


def box(values: Array) -> list[float]:
    """Of a box plot: lower whisker, quartiles, upper whisker (Tukey) and maximum, with few digits. Shape (t,)."""
    low, median, high = np.percentile(values, [25, 50, 75])
    reach = 1.5 * (high - low)
    inside = values[(values >= low - reach) & (values <= high + reach)]
    numbers = [inside.min(), low, median, high, inside.max(), values.max()]
    return [float(f"{v:.4g}") for v in numbers]


def _base(sim: Trace, measured: Trace) -> list[Difference]:
    """The differences of a moving base: from its recorded pose or, where there is none, from an IMU."""
    out = []
    if sim.base_position is not None and measured.base_position is not None:
        far = np.linalg.norm(sim.base_position - measured.base_position, axis=1)
        out.append(_of_base("base_position", far))
    if sim.base_quaternion is not None:
        if measured.base_quaternion is not None:
            angle = angle_between(sim.base_quaternion, measured.base_quaternion)
            out.append(_of_base("base_quaternion", angle))
        elif measured.imu_quaternion is not None:
            out.append(_of_base("base_quaternion", _tilt(sim.base_quaternion, measured.imu_quaternion)))
    if sim.base_angular is not None:
        if measured.base_angular is not None:
            rate = np.linalg.norm(sim.base_angular - measured.base_angular, axis=1)
            out.append(_of_base("base_angular", rate))
        elif measured.imu_angular is not None:
            # a gyroscope measures in its own axes; the size does not depend on them
            rate = np.linalg.norm(sim.base_angular, axis=1) - np.linalg.norm(measured.imu_angular, axis=1)
            out.append(_of_base("base_angular", np.abs(rate)))
    return out


def _of_base(signal: str, values: Array) -> Difference:
    name, unit, scale = BASE[signal]
    return Difference("base", name, unit, "base", scale, scale * values[np.isfinite(values)])


def _tilt(simulated: Array, imu: Array) -> Array:
    """The angle [rad] between the verticals of two orientations, relative to their first sample. Shape (k,).

    How an IMU is mounted is not known and its heading drifts, so only the path of the vertical is compared, in the
    axes that the base has at the first sample, turned about the vertical there to where the paths are closest.
    """
    known = np.isfinite(imu).all(axis=1)
    if not known.any():
        return np.empty(0)
    ours, theirs = vertical(simulated[known]), vertical(imu[known])
    theirs = theirs @ rotation_between(theirs[0], ours[0]).T
    up = ours[0]
    sine = np.sum(np.cross(theirs, ours) @ up)
    cosine = np.sum(theirs * ours) - np.sum((theirs @ up) * (ours @ up))
    theirs = theirs @ axis_rotation(up, float(np.arctan2(sine, cosine))).T
    chord = np.linalg.norm(ours - theirs, axis=1)
    return np.asarray(2.0 * np.arcsin(np.clip(chord / 2.0, 0.0, 1.0)))


def mean_trace(traces: Sequence[Trace]) -> Trace:
    """The mean of traces that share one clock and one order of joints; signals that all of them have."""
    first = traces[0]
    if len(traces) == 1:
        return first
    out: dict[str, Any] = {}
    for name in Trace.SIGNALS:
        values = [getattr(t, name) for t in traces]
        present = [v for v in values if v is not None]
        out[name] = np.mean(present, axis=0) if len(present) == len(values) else None
    for name in ("base_quaternion", "imu_quaternion"):
        if out[name] is not None:
            q = np.array([getattr(t, name) for t in traces])
            q = q * np.sign(np.sum(q * q[:1], axis=2, keepdims=True))
            mean = q.mean(axis=0)
            out[name] = mean / np.linalg.norm(mean, axis=1, keepdims=True)
    return Trace(time=first.time, joints=first.joints, **out)
