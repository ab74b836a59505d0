"""The state in which a simulation starts: measured joint angles, the base level on the ground."""

import numpy as np

from engines import State
from engines.model import (
    Array,
    Model,
    link_poses,
    lowest_point,
    quaternion_from_rotation,
    rotation_from_quaternion,
    rotation_from_rpy,
)
from harness.errors import InputError
from harness.plant import Plant

SOLE = 0.005
"""Contact points within this height [m] of the lowest one belong to the sole of a link."""


def start_state(
    plant: Plant,
    position: Array,
    *,
    stand_on: str | None = None,
    base_position: Array | None = None,
    base_quaternion: Array | None = None,
    base_linear: Array | None = None,
    base_angular: Array | None = None,
) -> State:
    """A state at rest at joint positions (n,), or with the measured velocity of a base that was recorded.

    Without a recorded height the lowest contact point is put on the ground. `stand_on` names the link whose sole is
    level; without it, and without a recorded orientation, the base is upright as in the URDF.

    Raises:
        InputError: for a `stand_on` that names no link.
    """
    model = plant.model
    state = State(np.asarray(position, dtype=float), np.zeros(len(model.joints)))
    rotation = np.eye(3)
    if base_quaternion is not None:
        rotation = rotation_from_quaternion(base_quaternion)
    elif stand_on is not None:
        rotation = _level(model, position, stand_on)
    if not model.floating:
        roll, pitch = plant.base_tilt
        rotation = rotation_from_rpy(roll, 0, 0) @ rotation_from_rpy(0, pitch, 0)
    state.base_quaternion = quaternion_from_rotation(rotation)
    pose = np.eye(4)
    pose[:3, :3] = rotation
    if base_position is not None:
        state.base_position = np.array(base_position, dtype=float)
    elif model.floating and plant.ground is not None:
        state.base_position[2] = -lowest_point(model, link_poses(model, position, pose))
    if base_linear is not None:
        state.base_linear = np.array(base_linear, dtype=float)
    if base_angular is not None:
        state.base_angular = np.array(base_angular, dtype=float)
    return state


def _level(model: Model, position: Array, name: str) -> Array:
    """The rotation of the base that puts the sole of a link level, as it is with all joints at zero. Shape (3, 3)."""
    found = [i for i, link in enumerate(model.links) if name == link.name or name in link.merged]
    if not found:
        known = sorted(n for link in model.links for n in link.merged)
        raise InputError(f"robot.stand_on: found {name!r}; expected one of the links {', '.join(known)}")
    i = found[0]
    zero = link_poses(model, np.zeros(len(model.joints)))[i][:3, :3]
    now = link_poses(model, position)[i][:3, :3]
    points = np.array([s.center - zero.T @ [0, 0, s.radius] for s in model.links[i].spheres])
    if len(points):
        heights = points @ zero[2]
        sole = points[heights < heights.min() + SOLE]
        if len(sole) >= 3:  # the plane through the sole, rather than the link's own axes, is what is level
            normal = np.linalg.svd(sole - sole.mean(axis=0))[2][2]
            normal = normal if normal @ zero[2] > 0 else -normal
            zero = _turn_onto(zero @ normal, np.array([0.0, 0.0, 1.0])) @ zero
    rotation: Array = zero @ now.T
    yaw = np.arctan2(rotation[1, 0], rotation[0, 0])
    return rotation_from_rpy(0, 0, -yaw) @ rotation


def _turn_onto(a: Array, b: Array) -> Array:
    """The shortest rotation that takes unit vector a onto b. Shape (3, 3)."""
    cross = np.cross(a, b)
    k = np.array([[0, -cross[2], cross[1]], [cross[2], 0, -cross[0]], [-cross[1], cross[0], 0]])
    rotation: Array = np.eye(3) + k + k @ k / (1 + a @ b)
    return rotation
