"""Rigid-body dynamics of the canonical tree, compiled: inertia matrix, bias and contact points at a state.

For laws that must know the machine outside an engine. Everything is in world axes about the present origin of the
base link, so that no frame changes occur: spatial vectors are (linear, angular), composite inertias just add.
Algorithms: composite rigid body and recursive Newton-Euler (Featherstone, Rigid Body Dynamics Algorithms, 2008).
"""
# mypy: allow-untyped-defs
# (the compiled functions take arrays and numbers only; their callers are typed)

import numpy as np
from numba import njit

from realitygap_engines.model.robot import Array, Model


class Dynamics:
    """The dynamics of a model at the state last given to `update`.

    Attributes:
        inertia: joint-space inertia, without armature, in the coordinates of `Simulation.mass_matrix`. Shape (nv, nv).
        bias: Coriolis, centrifugal and gravity terms as in `Simulation.bias`. Shape (nv,).
        ancestor: the next coordinate towards the root, -1 at the end; `inertia` is zero off these chains. Shape (nv,).
        motion: the velocity (linear at the base origin, angular) that each coordinate gives. Shape (nv, 6).
        swing: the angular acceleration of each link where no coordinate accelerates [rad/s²]. Shape (n + 1, 3).
        point: the lowest point of each contact sphere, from the base origin [m]. Shape (k, 3).
        height: its height above the ground [m]. Shape (k,).
        point_end: the last coordinate that moves it, -1 for a fixed base. Shape (k,).
    """

    def __init__(self, model: Model) -> None:
        n, links = len(model.joints), model.links
        first = 6 if model.floating else 0
        nv = first + n
        spheres = [(i, s) for i, link in enumerate(links) for s in link.spheres]
        self.inertia = np.zeros((nv, nv))
        self.bias = np.zeros(nv)
        self.motion = np.zeros((nv, 6))
        self.motion[:first, :first] = np.eye(first)
        self.point = np.zeros((len(spheres), 3))
        self.height = np.zeros(len(spheres))
        last = np.array([first - 1] + [first + i for i in range(n)], dtype=np.int64)
        parent = np.array([j.parent for j in model.joints], dtype=np.int64)
        self.ancestor = np.array([*range(-1, first - 1), *last[parent]], dtype=np.int64)
        sphere_link = np.array([i for i, _ in spheres], dtype=np.int64)
        self.point_end = last[sphere_link]
        self._tree = (
            parent,
            np.array([j.prismatic for j in model.joints], dtype=np.bool_),
            np.array([j.origin for j in model.joints]).reshape(n, 4, 4),
            np.array([j.axis for j in model.joints]).reshape(n, 3),
            np.array([link.mass for link in links]),
            np.array([link.com for link in links]),
            np.array([link.inertia for link in links]),
            sphere_link,
            np.array([[*s.center, s.radius] for _, s in spheres]).reshape(-1, 4),
        )
        flow = np.zeros((n + 1, 18))
        self.swing = flow[:, 9:12]
        self._work = (np.zeros((n + 1, 12)), flow, np.zeros((n + 1, 6, 6)))

    def update(self, position: Array, velocity: Array, base: Array, gravity: Array) -> None:
        """Take over a state: joints Shape (n,), the base row Shape (13,) of `Simulation.read`, gravity Shape (3,).

        The base row of a fixed base must hold its pose and zero velocity.
        """
        _update(
            position,
            velocity,
            base,
            gravity,
            *self._tree,
            *self._work,
            self.ancestor,
            self.motion,
            self.inertia,
            self.bias,
            self.point,
            self.height,
        )

    def inverse(self, position: Array, velocity: Array, acceleration: Array, base: Array, gravity: Array) -> Array:
        """The efforts M·a + c along a motion of the joints on a fixed base. Shapes (t, n); the base row as in `update`.

        Afterwards the state is that of the last sample.
        """
        out = np.empty_like(position)
        for k in range(len(position)):
            self.update(position[k], velocity[k], base, gravity)
            out[k] = self.inertia @ acceleration[k] + self.bias
        return out


@njit(cache=True)
def _update(
    position,
    velocity,
    base,
    gravity,
    parent,
    prismatic,
    origin,
    axis,
    mass,
    com,
    tensor,
    sphere_link,
    sphere,
    pose,
    flow,
    composite,
    ancestor,
    motion,
    inertia,
    bias,
    point,
    height,
):
    """`pose` is rotation (9) and position (3) of every link, `flow` its velocity, acceleration and force (6 each)."""
    n = len(parent)
    first = len(bias) - n
    w, x, y, z = base[3], base[4], base[5], base[6]
    s = 2.0 / (w * w + x * x + y * y + z * z)
    r = pose[0]
    r[0], r[1], r[2] = 1 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y)
    r[3], r[4], r[5] = s * (x * y + w * z), 1 - s * (x * x + z * z), s * (y * z - w * x)
    r[6], r[7], r[8] = s * (x * z - w * y), s * (y * z + w * x), 1 - s * (x * x + y * y)
    root = flow[0]
    for k in range(12):
        root[k] = 0.0
    if first:
        for k in range(6):
            root[k] = base[7 + k]
        # a spatial acceleration is that of a fixed point in space: the origin's own, less omega x v
        _cross(root, 3, root, 0, root, 6, -1.0)
    for k in range(3):
        root[6 + k] -= gravity[k]
    _inertia(composite[0], root, mass[0], com[0], tensor[0], r)

    for i in range(n):
        up, here, turn = pose[parent[i]], pose[i + 1], origin[i]
        a, b, c = axis[i]
        q = position[i]
        column = motion[first + i]
        for k in range(3):
            column[k] = 0.0
            column[3 + k] = 0.0
            here[9 + k] = up[9 + k] + up[3 * k] * turn[0, 3] + up[3 * k + 1] * turn[1, 3] + up[3 * k + 2] * turn[2, 3]
        frame = np.empty(9)
        for j in range(3):
            for k in range(3):
                frame[3 * j + k] = up[3 * j] * turn[0, k] + up[3 * j + 1] * turn[1, k] + up[3 * j + 2] * turn[2, k]
        direction = np.empty(3)
        for k in range(3):
            direction[k] = frame[3 * k] * a + frame[3 * k + 1] * b + frame[3 * k + 2] * c
        if prismatic[i]:
            for k in range(9):
                here[k] = frame[k]
            for k in range(3):
                here[9 + k] += q * direction[k]
                column[k] = direction[k]
        else:
            sin, cos = np.sin(q), np.cos(q)
            t = 1 - cos
            for k in range(3):
                u, v, w = frame[3 * k], frame[3 * k + 1], frame[3 * k + 2]
                d = t * direction[k]
                # row k of frame @ (cos*1 + sin*[axis] + t*axis axis^T)
                here[3 * k] = cos * u + sin * (v * c - w * b) + d * a
                here[3 * k + 1] = cos * v + sin * (w * a - u * c) + d * b
                here[3 * k + 2] = cos * w + sin * (u * b - v * a) + d * c
                column[3 + k] = direction[k]
            _cross(here, 9, direction, 0, column, 0, 1.0)
        above, now = flow[parent[i]], flow[i + 1]
        rate = velocity[i]
        for k in range(6):
            now[k] = above[k] + column[k] * rate
            now[6 + k] = above[6 + k]
        _cross(above, 3, column, 0, now, 6, rate)
        _cross(above, 0, column, 3, now, 6, rate)
        _cross(above, 3, column, 3, now, 9, rate)
        _inertia(composite[i + 1], now, mass[i + 1], com[i + 1], tensor[i + 1], here)

    for i in range(n - 1, -1, -1):
        column, force = motion[first + i], flow[i + 1]
        bias[first + i] = _dot(column, force, 12)
        for k in range(6):
            flow[parent[i], 12 + k] += force[12 + k]
        for j in range(6):
            for k in range(6):
                composite[parent[i], j, k] += composite[i + 1, j, k]
        momentum = np.empty(6)
        for j in range(6):
            momentum[j] = _dot(composite[i + 1, j], column, 0)
        j = first + i
        while j >= 0:
            inertia[first + i, j] = inertia[j, first + i] = _dot(motion[j], momentum, 0)
            j = ancestor[j]
    for j in range(first):
        bias[j] = root[12 + j]
        for k in range(first):
            inertia[j, k] = composite[0, j, k]

    for i in range(len(sphere_link)):
        here, ball = pose[sphere_link[i]], sphere[i]
        for k in range(3):
            point[i, k] = here[9 + k] + here[3 * k] * ball[0] + here[3 * k + 1] * ball[1] + here[3 * k + 2] * ball[2]
        point[i, 2] -= ball[3]
        height[i] = point[i, 2] + base[2]


@njit(cache=True, inline="always")
def _cross(a, i, b, j, out, k, scale):
    """Add scale * (a[i:i+3] x b[j:j+3]) to out[k:k+3]."""
    x = a[i + 1] * b[j + 2] - a[i + 2] * b[j + 1]
    y = a[i + 2] * b[j] - a[i] * b[j + 2]
    z = a[i] * b[j + 1] - a[i + 1] * b[j]
    out[k] += scale * x
    out[k + 1] += scale * y
    out[k + 2] += scale * z


@njit(cache=True, inline="always")
def _dot(a, b, j):
    """The product of a[0:6] and b[j:j+6]."""
    return a[0] * b[j] + a[1] * b[j + 1] + a[2] * b[j + 2] + a[3] * b[j + 3] + a[4] * b[j + 4] + a[5] * b[j + 5]


@njit(cache=True)
def _inertia(out, flow, mass, com, tensor, pose):
    """The spatial inertia of a link about the origin, and the force I a + v x* I v that its motion asks for."""
    c = np.empty(3)
    for k in range(3):
        c[k] = pose[9 + k] + pose[3 * k] * com[0] + pose[3 * k + 1] * com[1] + pose[3 * k + 2] * com[2]
    square = c[0] * c[0] + c[1] * c[1] + c[2] * c[2]
    half = np.empty((3, 3))
    for j in range(3):
        for k in range(3):
            half[j, k] = pose[3 * j] * tensor[0, k] + pose[3 * j + 1] * tensor[1, k] + pose[3 * j + 2] * tensor[2, k]
    for j in range(3):
        for k in range(3):
            out[j, k] = 0.0
            turned = half[j, 0] * pose[3 * k] + half[j, 1] * pose[3 * k + 1] + half[j, 2] * pose[3 * k + 2]
            out[3 + j, 3 + k] = turned - mass * c[j] * c[k]
        out[j, j] = mass
        out[3 + j, 3 + j] += mass * square
        out[j, 3 + j] = out[3 + j, j] = 0.0
    out[3, 1] = out[1, 3] = -mass * c[2]
    out[3, 2] = out[2, 3] = mass * c[1]
    out[4, 0] = out[0, 4] = mass * c[2]
    out[4, 2] = out[2, 4] = -mass * c[0]
    out[5, 0] = out[0, 5] = -mass * c[1]
    out[5, 1] = out[1, 5] = mass * c[0]
    momentum = np.empty(6)
    for j in range(6):
        momentum[j] = _dot(out[j], flow, 0)
        flow[12 + j] = _dot(out[j], flow, 6)
    _cross(flow, 3, momentum, 0, flow, 12, 1.0)
    _cross(flow, 3, momentum, 3, flow, 15, 1.0)
    _cross(flow, 0, momentum, 0, flow, 15, 1.0)
