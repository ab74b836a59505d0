"""The canonical robot that every engine gets: a tree of rigid links joined by one-degree-of-freedom joints.

Fixed joints are lumped into the links that carry them; visuals, materials, transmissions and sensors are dropped.
Contact geometry is a set of spheres per link that touches the ground plane exactly where the original shapes would.
Units are SI; poses are 4x4 homogeneous matrices.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Sphere:
    """A contact sphere: `center` (3,) [m] in the link frame and `radius` [m]."""

    center: Array
    radius: float


@dataclass(frozen=True)
class Link:
    """A rigid body: `mass` [kg], `com` (3,) [m] and `inertia` (3, 3) [kg·m²] about the centre of mass, link axes.

    `merged` names the URDF links that were lumped into this one (itself first); `held` are mass, com and inertia of
    those that joints would move if they were not held, which are part of it too.
    """

    name: str
    mass: float
    com: Array
    inertia: Array
    spheres: tuple[Sphere, ...] = ()
    merged: tuple[str, ...] = ()
    held: tuple[tuple[float, Array, Array], ...] = ()


@dataclass(frozen=True)
class Mimic:
    """A coupling of gears or rods: the position of a joint is `multiplier` times that of `joint`, and `offset`."""

    joint: str
    multiplier: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True)
class Joint:
    """A revolute or prismatic joint from link `parent` (an index into `Model.links`) to link number i + 1.

    `origin` (4, 4) is the joint frame, which is the child link's frame at zero, in the parent link's frame, `axis`
    (3,) a unit vector in it. `effort` [N·m or N] and `velocity` [rad/s or m/s] are the URDF's limits (inf: none);
    `friction`, `damping` and `armature` are the joint's own dry friction, viscous damping and rotor inertia. `mimic`
    couples it to another joint, which is itself free.
    """

    name: str
    prismatic: bool
    parent: int
    origin: Array
    axis: Array
    lower: float = -np.inf
    upper: float = np.inf
    effort: float = np.inf
    velocity: float = np.inf
    friction: float = 0.0
    damping: float = 0.0
    armature: float = 0.0
    mimic: Mimic | None = None


@dataclass(frozen=True)
class Actuator:
    """What drives a joint, where the robot's file says it: `kind` and `values` are those of a servo in a scenario."""

    joint: str
    kind: str
    values: Mapping[str, float]


@dataclass(frozen=True)
class Model:
    """A robot. `links[0]` is the base and `links[i + 1]` the child of `joints[i]`; parents come before children.

    `floating` says whether the base moves freely. `notes` are sentences on what was simplified or left out.
    `actuators` drive the joints where a scenario names no servos.
    """

    name: str
    links: tuple[Link, ...]
    joints: tuple[Joint, ...]
    floating: bool
    notes: tuple[str, ...] = field(default=())
    actuators: tuple[Actuator, ...] = ()

    def __repr__(self) -> str:
        base = "floating" if self.floating else "fixed"
        return (
            f"<Model {self.name}: {len(self.links)} links, {len(self.joints)} joints, {base} base, {self.mass:.4g} kg>"
        )

    @property
    def joint_names(self) -> list[str]:
        """Joint names in the model's order."""
        return [joint.name for joint in self.joints]

    @property
    def mimics(self) -> dict[str, Mimic]:
        """What couples joints to others, by the name of the joint that follows."""
        return {joint.name: joint.mimic for joint in self.joints if joint.mimic is not None}

    @property
    def limits(self) -> dict[str, tuple[float, float]]:
        """The lower and upper limit [rad] of the joints that turn and have both, by their names."""
        ends = {j.name: (j.lower, j.upper) for j in self.joints if not j.prismatic}
        return {name: both for name, both in ends.items() if np.isfinite(both).all()}

    @property
    def mass(self) -> float:
        """Total mass [kg]."""
        return sum(link.mass for link in self.links)

    @property
    def armature(self) -> Array:
        """Rotor inertia of every joint [kg·m² or kg]. Shape (n,)."""
        return np.array([joint.armature for joint in self.joints])

    def with_armature(self, armature: Array) -> "Model":
        """The same robot with these rotor inertias. Shape (n,)."""
        joints = tuple(replace(j, armature=float(a)) for j, a in zip(self.joints, armature, strict=True))
        return replace(self, joints=joints)


def rotation_from_rpy(roll: float, pitch: float, yaw: float) -> Array:
    """The rotation matrix of URDF's fixed-axis roll, pitch, yaw [rad]. Shape (3, 3)."""
    cr, sr, cp, sp, cy, sy = np.cos(roll), np.sin(roll), np.cos(pitch), np.sin(pitch), np.cos(yaw), np.sin(yaw)
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def rotation_from_quaternion(quaternion: Array) -> Array:
    """The rotation matrix of a unit quaternion w x y z. Shape (3, 3)."""
    w, x, y, z = quaternion / np.linalg.norm(quaternion)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def quaternion_from_rotation(rotation: Array) -> Array:
    """The unit quaternion w x y z (w >= 0) of a rotation matrix (Shepperd 1978). Shape (4,)."""
    trace = np.trace(rotation)
    diagonal = np.append(np.diag(rotation), trace)
    i = int(np.argmax(diagonal))
    q = np.empty(4)
    if i == 3:
        q[0] = 1 + trace
        q[1] = rotation[2, 1] - rotation[1, 2]
        q[2] = rotation[0, 2] - rotation[2, 0]
        q[3] = rotation[1, 0] - rotation[0, 1]
    else:
        j, k = (i + 1) % 3, (i + 2) % 3
        q[0] = rotation[k, j] - rotation[j, k]
        q[1 + i] = 1 + rotation[i, i] - rotation[j, j] - rotation[k, k]
        q[1 + j] = rotation[j, i] + rotation[i, j]
        q[1 + k] = rotation[k, i] + rotation[i, k]
    q /= np.linalg.norm(q)
    return -q if q[0] < 0 else q


def axis_rotation(axis: Array, angle: float | Array) -> Array:
    """The rotation matrix about a unit axis by an angle [rad], or by many (...) (Rodrigues). Shape (..., 3, 3)."""
    x, y, z = axis
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    turn = np.asarray(angle)[..., None, None]
    rotation: Array = np.eye(3) + np.sin(turn) * cross + (1 - np.cos(turn)) * (cross @ cross)
    return rotation


def rotation_between(a: Array, b: Array) -> Array:
    """The shortest rotation that takes the unit vector a onto b, where they are not opposite. Shape (3, 3)."""
    x, y, z = np.cross(a, b)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    rotation: Array = np.eye(3) + cross + cross @ cross / (1 + a @ b)
    return rotation


def frame_along(axis: Array) -> Array:
    """A rotation matrix whose last column is a unit axis. Shape (3, 3)."""
    side = np.cross(np.eye(3)[np.argmin(np.abs(axis))], axis)
    side /= np.linalg.norm(side)
    return np.column_stack([side, np.cross(axis, side), axis])


def link_poses(model: Model, position: Array, base: Array | None = None) -> Array:
    """The pose of every link at joint positions (..., n) for base poses (..., 4, 4), default identity.

    Shape (n + 1, ..., 4, 4).
    """
    many = position.shape[:-1]
    poses = np.empty((len(model.links), *many, 4, 4))
    poses[0] = np.eye(4) if base is None else base
    for i, joint in enumerate(model.joints):
        motion = np.zeros((*many, 4, 4))
        motion[..., range(4), range(4)] = 1.0
        if joint.prismatic:
            motion[..., :3, 3] = joint.axis * position[..., i, None]
        else:
            motion[..., :3, :3] = axis_rotation(joint.axis, position[..., i])
        poses[i + 1] = poses[joint.parent] @ joint.origin @ motion
    return poses


def lowest_point(model: Model, poses: Array) -> float:
    """The height [m] of the lowest point of all contact spheres for the given link poses; 0 where there is none."""
    heights = [
        (pose[:3, :3] @ s.center + pose[:3, 3])[2] - s.radius
        for link, pose in zip(model.links, poses, strict=True)
        for s in link.spheres
    ]
    return min(heights, default=0.0)
