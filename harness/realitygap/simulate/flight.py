"""How a body was thrown: its pose and velocity at the first sample, from all samples until it first touches the ground.

A recorded velocity is a filtered difference of positions, late and biased by some cm/s; where a thrown body comes to
rest depends on less. The flight itself tells better: its centre of mass falls, and it turns free of torque.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit
from realitygap_engines import GRAVITY
from realitygap_engines.model.robot import Array, Model
from scipy.spatial.transform import Rotation

from realitygap.trace.trace import Trace

CLEAR = 1e-3
"""The flight ends where the lowest contact point comes closer to the ground than this [m]."""
FEWEST = 4
"""A flight of fewer samples tells no velocity."""
FALLS = 2e-3
"""A body whose centre of mass is further from a free fall than this [m rms] was held or blown, and not thrown."""
FALL = np.array([0.0, 0.0, -GRAVITY])
SUBSTEP = 2e-3
TURNS, SMALL = 3, 1e-5


@dataclass(frozen=True)
class Launch:
    """Where a flight began: position of the base (3,) [m], quaternion (4,) w x y z, and velocities (3,) of the base
    [m/s, rad/s] in world axes; by how much the readings `missed` it, in root mean square along an axis [m, rad].
    """

    position: Array
    quaternion: Array
    linear: Array
    angular: Array
    missed: tuple[float, float]


def launch(model: Model, trace: Trace) -> Launch | None:
    """The start of a body that is thrown, at the trace's first sample; None where it does not fly from there.

    Least squares: a parabola for the centre of mass, and for the orientations those of a body free of torque.
    """
    body = model.links[0]
    if trace.base_position is None or trace.base_quaternion is None or trace.base_angular is None:
        return None
    p, q = trace.base_position, trace.base_quaternion
    count = flying(model, p, q)
    if count < FEWEST or not np.isfinite(trace.base_angular[0]).all():
        return None
    time, turned = trace.time[:count] - trace.time[0], rotation_of(q[:count])
    line = np.column_stack([np.ones(count), time])
    centre = p[:count] + turned.apply(body.com) - 0.5 * np.outer(time**2, FALL)
    place, speed = found = np.linalg.lstsq(line, centre, rcond=None)[0]
    far = np.sqrt(np.mean(np.sum((line @ found - centre) ** 2, axis=1)))
    if far > FALLS:
        return None
    start, spin, angle = _spun(time, turned, trace.base_angular[0], body.inertia)
    arm = start.apply(body.com)
    return Launch(
        place - arm, _quaternion(start), speed - np.cross(spin, arm), spin, (float(far) / np.sqrt(3.0), angle)
    )


def _spun(time: Array, turned: Rotation, spin: Array, inertia: Array) -> tuple[Rotation, Array, float]:
    """Orientation and angular velocity [rad/s] at the first time of a body free of torque, by Gauss and Newton, and by
    how much the orientations miss that motion, in root mean square about an axis [rad].
    """
    start, tries = turned[0], np.vstack([np.zeros(6), SMALL * np.eye(6)])
    measured = turned[np.tile(np.arange(len(time)), len(tries))]

    for _ in range(TURNS):
        # what is left of the turn [rad] after small changes of orientation and angular velocity. Shape (7, 3 k)
        firsts = _quaternion(Rotation.from_rotvec(tries[:, :3]) * start)
        ways = [tumble(time, first, spin + t[3:], inertia) for first, t in zip(firsts, tries, strict=True)]
        left = (measured * rotation_of(np.concatenate(ways)).inv()).as_rotvec().reshape(len(tries), -1)
        here, slope = left[0], ((left[1:] - left[0]) / SMALL).T
        change = np.linalg.lstsq(slope, -here, rcond=None)[0]
        start, spin = Rotation.from_rotvec(change[:3]) * start, spin + change[3:]
        if np.abs(change).max() < SMALL:
            break
    return start, spin, float(np.sqrt(np.mean(left**2)))


def flying(model: Model, position: Array, quaternion: Array) -> int:
    """How many poses of a free body there are before the first that is missing or near the ground.

    Shapes (t, 3) and (t, 4).
    """
    there = np.isfinite(np.column_stack([position, quaternion])).all(axis=1)
    known = np.where(there.reshape(-1, 1), quaternion, [1.0, 0.0, 0.0, 0.0])
    clear = position[:, 2].copy()
    upward = rotation_of(known).as_matrix()[:, 2]
    for sphere in model.links[0].spheres:
        clear = np.minimum(clear, position[:, 2] + upward @ sphere.center - sphere.radius)
    flies = there & (clear >= CLEAR)
    return len(flies) if flies.all() else int(np.argmin(flies))


def rotation_of(quaternion: Array) -> Rotation:
    """SciPy's rotations of quaternions w x y z. Shape (..., 4)."""
    return Rotation.from_quat(quaternion[..., [1, 2, 3, 0]])


def _quaternion(rotation: Rotation) -> Array:
    return np.ascontiguousarray(rotation.as_quat()[..., [3, 0, 1, 2]])


@njit(cache=True)
def tumble(time, start, spin, inertia):  # type: ignore[no-untyped-def]
    """The orientations of a body free of torque, by Runge and Kutta's fourth order.

    Args:
        time: increasing [s]. Shape (k,).
        start: quaternion w x y z at the first time. Shape (4,).
        spin: angular velocity at the first time, world axes [rad/s]. Shape (3,).
        inertia: about the centre of mass, in the body's axes [kg·m²]. Shape (3, 3).

    Returns:
        Quaternions. Shape (k, 4).
    """
    inverse = np.linalg.inv(inertia)
    x, rates, there = np.empty(7), np.empty((4, 7)), np.empty(7)
    x[:4] = start
    w, v = start[0], start[1:]
    turned = 2.0 * np.cross(-v, spin)
    x[4:] = spin + w * turned + np.cross(-v, turned)
    out = np.empty((len(time), 4))
    out[0] = start
    for i in range(1, len(time)):
        count = int(np.ceil((time[i] - time[i - 1]) / SUBSTEP))
        h = (time[i] - time[i - 1]) / count
        for _ in range(count):
            _rate(x, inertia, inverse, rates[0])
            for stage in range(1, 4):
                share = h if stage == 3 else 0.5 * h
                for k in range(7):
                    there[k] = x[k] + share * rates[stage - 1, k]
                _rate(there, inertia, inverse, rates[stage])
            for k in range(7):
                x[k] += h / 6 * (rates[0, k] + 2 * rates[1, k] + 2 * rates[2, k] + rates[3, k])
        out[i] = x[:4] / np.linalg.norm(x[:4])
    return out


@njit(cache=True)
def _rate(x, inertia, inverse, out):  # type: ignore[no-untyped-def]
    """Of quaternion and angular velocity in body axes, into `out`. Shape (7,)."""
    w, a, b, c, p, q, r = x
    out[0] = -0.5 * (a * p + b * q + c * r)
    out[1] = 0.5 * (w * p + b * r - c * q)
    out[2] = 0.5 * (w * q + c * p - a * r)
    out[3] = 0.5 * (w * r + a * q - b * p)
    i = inertia[0, 0] * p + inertia[0, 1] * q + inertia[0, 2] * r
    j = inertia[1, 0] * p + inertia[1, 1] * q + inertia[1, 2] * r
    k = inertia[2, 0] * p + inertia[2, 1] * q + inertia[2, 2] * r
    torque = (j * r - k * q, k * p - i * r, i * q - j * p)
    for n in range(3):
        out[4 + n] = inverse[n, 0] * torque[0] + inverse[n, 1] * torque[1] + inverse[n, 2] * torque[2]
