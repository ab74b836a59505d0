"""The measured state at one moment of a motion, with its standard errors: where a window starts.

Joints take it from the smoothing spline of all their readings. A body that is thrown hits the ground, which no smooth
curve passes through: its state is that of a parabola through the nearest readings, and of as many as its flight has
where it flies (`realitygap.simulate.flight`), whose errors say how badly that fits.
"""

from __future__ import annotations

import numpy as np
from realitygap_engines import GRAVITY
from realitygap_engines.model.robot import Model
from scipy.spatial.transform import Rotation

from realitygap.diagnose.data.case import Case
from realitygap.recording.frames import rotation_vector
from realitygap.robot.drive import Array
from realitygap.simulate.flight import FEWEST, flying, launch
from realitygap.simulate.midway import Midway, Moving
from realitygap.simulate.smooth import Smoothed, smooth
from realitygap.trace.trace import Trace

NEAR = 3
"""Readings on either side that tell a body's state."""


class Moments:
    """The measured states of a motion."""

    def __init__(self, case: Case) -> None:
        self._case, self._trace = case, case.measured
        self._model: Model = case.experiment.plant.loaded()
        position = self._trace.position
        n = len(self._trace.joints)
        self._joints: Smoothed | None = smooth(self._trace.time, position) if position is not None and n else None

    def at(self, k: int) -> Midway:
        """The state at sample k."""
        joints = _nothing() if self._joints is None else _of_joints(self._joints, k)
        if not self._model.floating:
            return Midway(joints)
        assert self._trace.base_quaternion is not None
        place, turn = self._body(k)
        return Midway(joints, place, turn, self._trace.base_quaternion[k])

    def doubt(self, k: int) -> float:
        """How badly the velocity is known at sample k, in its own units [m/s, rad/s or rad/s]: larger is worse."""
        if not self._model.floating:
            return 0.0  # a spline's error is about the same everywhere
        place, turn = self._body(k)
        return float(np.linalg.norm(place.velocity_error) + self._reach() * np.linalg.norm(turn.velocity_error))

    def _reach(self) -> float:
        """About how far the body extends [m]: what an angular velocity moves."""
        spheres = self._model.links[0].spheres
        return max((float(np.linalg.norm(s.center) + s.radius) for s in spheres), default=0.1)

    def _body(self, k: int) -> tuple[Moving, Moving]:
        noise = self._case.noise
        far, angle = noise["base_position"], 2.0 * np.linalg.norm(noise["base_quaternion"]) / np.sqrt(3.0)
        rest = self._trace.rows(np.arange(k, len(self._trace.time)))
        flight = _flight(self._model, rest, far, np.full(3, angle))
        return _near(self._trace, k, far, np.full(3, angle)) if flight is None else flight


def _nothing() -> Moving:
    none = np.zeros(0)
    return Moving(none, none, none, none, none)


def _of_joints(smoothed: Smoothed, k: int) -> Moving:
    position, velocity, acceleration = smoothed.value[:, k]
    return Moving(position, velocity, acceleration, smoothed.error[0, k], smoothed.error[1, k])


def _flight(model: Model, trace: Trace, far: Array, angle: Array) -> tuple[Moving, Moving] | None:
    """Of a body that flies from the first sample on; None where it does not."""
    if len(model.joints) or len(trace.time) < FEWEST:
        return None
    assert trace.base_position is not None
    assert trace.base_quaternion is not None
    count = flying(model, trace.base_position, trace.base_quaternion)
    told = launch(model, trace) if count >= FEWEST else None
    if told is None:
        return None
    # of a line, at its end (least squares); by what the flight misses its readings, which lasts, it may be off as well
    lasting = trace.time[count - 1] - trace.time[0]
    far, angle = (np.hypot(e / np.sqrt(count), m) for e, m in zip((far, angle), told.missed, strict=True))
    begun, going = 2.0, np.sqrt(12.0) / lasting
    fall, none = np.array([0.0, 0.0, -GRAVITY]), np.zeros(3)
    first = rotation_vector(trace.base_quaternion[:1], told.quaternion[None])[0]
    turned = Rotation.from_quat(np.roll(trace.base_quaternion[0], -1)).apply(first)
    place = Moving(told.position, told.linear, fall, begun * far, going * far)
    return place, Moving(turned, told.angular, none, begun * angle, going * angle)


def _near(trace: Trace, k: int, far: Array, angle: Array) -> tuple[Moving, Moving]:
    """Of a body anywhere, from the nearest readings."""
    assert trace.base_position is not None
    assert trace.base_quaternion is not None
    begin = int(np.clip(k - NEAR, 0, max(len(trace.time) - 2 * NEAR - 1, 0)))
    rows = slice(begin, begin + 2 * NEAR + 1)
    time, here = trace.time[rows] - trace.time[k], trace.base_quaternion[k]
    turns = rotation_vector(np.tile(here, (len(time), 1)), trace.base_quaternion[rows])
    world = Rotation.from_quat(np.roll(here, -1)).apply(turns)
    return _parabola(time, trace.base_position[rows], far), _parabola(time, world, angle)


def _parabola(time: Array, value: Array, noise: Array) -> Moving:
    """A parabola's value, slope and curvature at time 0, in readings of at least this noise. Shapes (m, 3), (3,)."""
    terms = np.column_stack([np.ones_like(time), time, 0.5 * time**2])
    found = np.linalg.lstsq(terms, value, rcond=None)[0]
    left = np.sum((value - terms @ found) ** 2, axis=0) / max(len(time) - 3, 1)
    spread = np.sqrt(np.diag(np.linalg.inv(terms.T @ terms)))[:, None] * np.sqrt(np.maximum(left, noise**2))
    return Moving(found[0], found[1], found[2], spread[0], spread[1])
