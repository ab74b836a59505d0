"""Footing: whether a robot on its feet keeps them, flat and in their places, through a motion.

The centre of pressure is where the ground's force has no moment about horizontal axes; it follows from how bodies move
and from their weight alone (Vukobratović & Borovac 2004). While it is inside the sole, no edge of it is lifted.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from realitygap_engines import GRAVITY
from realitygap_engines.model.robot import Model, link_poses

from realitygap.robot.drive import Array
from realitygap.simulate.flight import rotation_of
from realitygap.trace.trace import Trace

EDGE = 0.1
"""The share of a sole, from its middle to an edge, that the centre of pressure stays away from the edge."""
MOVED = 0.005
"""How far a point of a foot may move [m]: by a hundredth of a humanoid's height it has slipped or is lifted. In squats
of a recorded one, as they are simulated, soles creep by 0.3 mm."""
TOUCHING = 0.002
"""Points that are no higher above the ground are those that a robot stands on [m]."""
SPAN = 0.01
"""Accelerations are means over so much on either side [s]: shorter than a robot takes to tip, longer than contacts
chatter."""


class Footing(NamedTuple):
    """Where and how a robot stands, by samples.

    Attributes:
        time: [s]. Shape (t,).
        pressure: the centre of pressure on the ground [m]. Shape (t, 2).
        points: the contact points of what touches the ground at first [m]. Shape (t, p, 3).
    """

    time: Array
    pressure: Array
    points: Array


def lost_footing(model: Model, trace: Trace) -> Array:
    """When a robot does not keep the feet that it stands on where a trace begins [s]. Shape (k,).

    Where it stands on fewer than three points, or on points in a line, that is always.
    """
    footing = footing_of(model, trace)
    return footing.time[beyond(footing) > 0.0]


def beyond(footing: Footing) -> Array:
    """How far each sample is from keeping the feet, as a share of what there is; below 0 where it does. Shape (t,)."""
    points = footing.points
    sole = _sole(points[0, :, :2])
    if sole is None:
        return np.ones(len(footing.time))
    normals, offsets = sole
    middle = points[0, :, :2].mean(axis=0)
    deep = -(normals @ middle + offsets)
    pressed = ((footing.pressure @ normals.T + offsets) / deep).max(axis=1) + EDGE
    moved = np.linalg.norm(points - points[0], axis=2).max(axis=1) / MOVED - 1.0
    return np.asarray(np.maximum(pressed, moved))


def _sole(points: Array) -> tuple[Array, Array] | None:
    """The edges of the hull of points (p, 2): normals that point out, (e, 2), and offsets (e,); None where it has no
    inside.
    """
    from scipy.spatial import ConvexHull, QhullError  # few robots stand

    if len(points) < 3:
        return None
    try:
        equations = ConvexHull(points).equations
    except QhullError:
        return None
    return equations[:, :2], equations[:, 2]


def footing_of(model: Model, trace: Trace) -> Footing:
    """Where and how a robot stands.

    Args:
        model: of the robot, with what it carries.
        trace: of a simulation on every step, with joints and a floating base.
    """
    assert trace.position is not None
    every = max(round(SPAN / float(np.median(np.diff(trace.time)))), 1)
    rows = slice(None, None, every)
    time, base = trace.time[rows], _base(trace, rows)
    poses = link_poses(model, trace.position[rows], base)
    return Footing(time, _pressure(model, time, poses), _touching(model, poses))


def _base(trace: Trace, rows: slice) -> Array:
    """The pose of the base. Shape (t, 4, 4)."""
    assert trace.base_position is not None
    assert trace.base_quaternion is not None
    quaternion = trace.base_quaternion[rows]
    out = np.tile(np.eye(4), (len(quaternion), 1, 1))
    out[:, :3, :3] = rotation_of(quaternion).as_matrix()
    out[:, :3, 3] = trace.base_position[rows]
    return out


def _pressure(model: Model, time: Array, poses: Array) -> Array:
    """The centre of pressure, from what the weight and the momenta of the links take: the moment of the ground's force
    about the origin is Σ c × m·(c'' + g) + d/dt Σ I·ω. Shape (t, 2).
    """
    force, moment = np.zeros((len(time), 3)), np.zeros((len(time), 3))
    step, up = np.diff(time)[:, None], np.array([0.0, 0.0, 1.0])
    for link, pose in zip(model.links, poses, strict=True):
        rotation = pose[:, :3, :3]
        centre = rotation @ link.com + pose[:, :3, 3]
        pull = link.mass * (_slope(np.diff(centre, axis=0) / step, step) + GRAVITY * up)
        turned = rotation[1:] @ rotation[:-1].swapaxes(1, 2)
        spin = 0.5 * np.stack([turned[:, i, j] - turned[:, j, i] for i, j in ((2, 1), (0, 2), (1, 0))], axis=1) / step
        inertia = rotation[:-1] @ link.inertia @ rotation[:-1].swapaxes(1, 2)
        force += pull
        moment += np.cross(centre, pull) + _slope(np.einsum("tij,tj->ti", inertia, spin), step)
    weight = np.maximum(force[:, 2], 1e-3 * model.mass * GRAVITY)[:, None]  # a robot in the air presses nowhere
    return np.asarray(np.stack([-moment[:, 1], moment[:, 0]], axis=1) / weight)


def _slope(between: Array, step: Array) -> Array:
    """How what is known between samples changes at each: as at its neighbour at both ends. (t - 1, 3) -> (t, 3)."""
    inside = np.diff(between, axis=0) / step[1:]
    return np.concatenate([inside[:1], inside, inside[-1:]])


def _touching(model: Model, poses: Array) -> Array:
    """The lowest points of the contact spheres that are on the ground at first. Shape (t, p, 3)."""
    down = np.array([0.0, 0.0, 1.0])
    every = [
        pose[:, :3, :3] @ sphere.center + pose[:, :3, 3] - sphere.radius * down
        for link, pose in zip(model.links, poses, strict=True)
        for sphere in link.spheres
    ]
    points = np.stack(every, axis=1) if every else np.zeros((poses.shape[1], 0, 3))
    on: NDArray[np.bool_] = points[0, :, 2] < TOUCHING
    return points[:, on]
