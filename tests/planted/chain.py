"""Rigid bodies in a row: inverse dynamics of a serial chain on a fixed base (recursive Newton-Euler).

R. Featherstone, Rigid Body Dynamics Algorithms, 2008, section 5.3, written for 3-vectors in link frames.
"""

from dataclasses import dataclass, field

import numba
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
GRAVITY = 9.81


@dataclass
class Chain:
    """n joints and n links from the base outwards. A link's frame is its joint's.

    Attributes:
        prismatic: Shape (n,).
        axis: joint axis in the link frame, unit length. Shape (n, 3).
        origin: joint origin in the parent's frame [m]. Shape (n, 3).
        turn: rotation of the joint frame in the parent's frame. Shape (n, 3, 3).
        mass: Shape (n,) [kg].
        com: centre of mass in the link frame. Shape (n, 3) [m].
        inertia: about the centre of mass, axes of the link frame. Shape (n, 3, 3) [kg·m²].
        gravity: acceleration of gravity in the base frame. Shape (3,) [m/s²].
    """

    prismatic: NDArray[np.bool_]
    axis: Array
    origin: Array
    turn: Array
    mass: Array
    com: Array
    inertia: Array
    gravity: Array = field(default_factory=lambda: np.array([0.0, 0.0, -GRAVITY]))

    def arrays(self) -> tuple[np.ndarray, ...]:
        return (
            self.prismatic,
            self.axis,
            self.origin,
            self.turn,
            self.mass,
            self.com,
            self.inertia,
            self.gravity,
        )

    def torque(self, q: Array, w: Array, a: Array) -> Array:
        """Joint efforts for a motion: position, velocity, acceleration, each of shape (n,)."""
        n = len(self.mass)
        out = np.zeros(n)
        inverse_dynamics(*self.arrays(), q, w, a, np.zeros((n, 3, 3)), np.zeros((n, 6)), out)
        return out


@numba.njit(inline="always")
def _cross(a, b):  # type: ignore[no-untyped-def]
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


@numba.njit(inline="always")
def _add(a, b):  # type: ignore[no-untyped-def]
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


@numba.njit(inline="always")
def _scaled(v, s):  # type: ignore[no-untyped-def]
    return (v[0] * s, v[1] * s, v[2] * s)


@numba.njit(inline="always")
def _times(m, v):  # type: ignore[no-untyped-def]
    return (
        m[0, 0] * v[0] + m[0, 1] * v[1] + m[0, 2] * v[2],
        m[1, 0] * v[0] + m[1, 1] * v[1] + m[1, 2] * v[2],
        m[2, 0] * v[0] + m[2, 1] * v[1] + m[2, 2] * v[2],
    )


@numba.njit(inline="always")
def _back(m, v):  # type: ignore[no-untyped-def]
    return (
        m[0, 0] * v[0] + m[1, 0] * v[1] + m[2, 0] * v[2],
        m[0, 1] * v[0] + m[1, 1] * v[1] + m[2, 1] * v[2],
        m[0, 2] * v[0] + m[1, 2] * v[1] + m[2, 2] * v[2],
    )


@numba.njit(inline="always")
def _row(x, i):  # type: ignore[no-untyped-def]
    return (x[i, 0], x[i, 1], x[i, 2])


@numba.njit(cache=True)
def _rotation(turn, axis, angle, out):  # type: ignore[no-untyped-def]
    """Turn times the rotation about an axis (Rodrigues)."""
    c, s = np.cos(angle), np.sin(angle)
    x, y, z = axis[0], axis[1], axis[2]
    k = 1.0 - c
    r00, r01, r02 = c + x * x * k, x * y * k - z * s, x * z * k + y * s
    r10, r11, r12 = y * x * k + z * s, c + y * y * k, y * z * k - x * s
    r20, r21, r22 = z * x * k - y * s, z * y * k + x * s, c + z * z * k
    for i in range(3):
        t0, t1, t2 = turn[i, 0], turn[i, 1], turn[i, 2]
        out[i, 0] = t0 * r00 + t1 * r10 + t2 * r20
        out[i, 1] = t0 * r01 + t1 * r11 + t2 * r21
        out[i, 2] = t0 * r02 + t1 * r12 + t2 * r22


@numba.njit(cache=True)
def inverse_dynamics(prismatic, axis, origin, turn, mass, com, inertia, gravity, q, w, a, R, wrench, out):  # type: ignore[no-untyped-def]
    """Efforts `out` (n,) for a motion; `R` (n, 3, 3) and `wrench` (n, 6) are room to work in."""
    n = mass.size
    om, al = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    ac = (-gravity[0], -gravity[1], -gravity[2])
    for i in range(n):
        u = _row(axis, i)
        _rotation(turn[i], axis[i], 0.0 if prismatic[i] else q[i], R[i])
        r = _row(origin, i)
        if prismatic[i]:
            r = _add(r, _scaled(_times(turn[i], u), q[i]))
        ac = _add(ac, _add(_cross(al, r), _cross(om, _cross(om, r))))
        om, al, ac = _back(R[i], om), _back(R[i], al), _back(R[i], ac)
        if prismatic[i]:
            ac = _add(ac, _add(_scaled(u, a[i]), _scaled(_cross(om, u), 2.0 * w[i])))
        else:
            al = _add(al, _add(_scaled(u, a[i]), _cross(om, _scaled(u, w[i]))))
            om = _add(om, _scaled(u, w[i]))
        c = _row(com, i)
        f = _scaled(_add(ac, _add(_cross(al, c), _cross(om, _cross(om, c)))), mass[i])
        m = _add(_times(inertia[i], al), _cross(om, _times(inertia[i], om)))
        m = _add(m, _cross(c, f))
        for k in range(3):
            wrench[i, k] = f[k]
            wrench[i, 3 + k] = m[k]
    for i in range(n - 1, -1, -1):
        u = _row(axis, i)
        first = 0 if prismatic[i] else 3
        out[i] = u[0] * wrench[i, first] + u[1] * wrench[i, first + 1] + u[2] * wrench[i, first + 2]
        if i > 0:
            f = _times(R[i], (wrench[i, 0], wrench[i, 1], wrench[i, 2]))
            m = _times(R[i], (wrench[i, 3], wrench[i, 4], wrench[i, 5]))
            r = _row(origin, i)
            if prismatic[i]:
                r = _add(r, _scaled(_times(turn[i], u), q[i]))
            m = _add(m, _cross(r, f))
            for k in range(3):
                wrench[i - 1, k] += f[k]
                wrench[i - 1, 3 + k] += m[k]
