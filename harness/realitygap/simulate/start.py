"""The state in which a simulation starts: measured joint angles, the base level on the ground, charged integrals, play
and springs under their load.
"""

import numpy as np
from numpy.typing import NDArray
from realitygap_engines import GRAVITY, State
from realitygap_engines.model.robot import (
    Array,
    Model,
    link_poses,
    lowest_point,
    quaternion_from_rotation,
    rotation_between,
    rotation_from_quaternion,
    rotation_from_rpy,
)
from scipy.spatial import ConvexHull

from realitygap.files.errors import InputError
from realitygap.robot.drive import NONE, PID, POSITION
from realitygap.robot.plant import Plant
from realitygap.simulate.commands import Commands
from realitygap.trace.trace import Trace

SOLE = 0.005
"""Contact points that spread less than this [m] along an axis are flat."""
FLAT = 0.02
"""Faces whose normals differ by less than this [rad] are one."""
SMALL = 1e-6
"""Half the difference [rad or m] of a slope."""
RESTED = 1.0
"""A joint that rests has done so for about this time [s], in which its load moves it to the end of its play."""
RECENT = 0.1
"""An integral is told from the first readings of this time [s], in which it hardly changes."""


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
        rotation = _tilted(plant)
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


def start_integral(plant: Plant, measured: Trace, commands: Commands, begin: float) -> Array:
    """The integral [N·m or N] that each PID servo has gathered before its recording begins. Shape (n,).

    What the motor was measured to give beyond its proportional and damping part, τ − kp·e + kd·ω, in the mean over the
    first readings for which the first command holds; 0 where that is within three standard errors of it. Without a
    measured effort it is what holds the robot still, unless the proportional part alone is more than that and moves it.
    0 where there is no integral gain or no command.

    Args:
        plant: with its drives.
        measured: position, and the motor's own effort where that was measured.
        commands: on the simulation's clock.
        begin: where that clock starts in the recording [s].
    """
    drive = plant.drive
    first = _in_force(commands)  # what was sent before is over
    commands = Commands(commands.time[first:], commands.value[first:], commands.held)
    out, gathers = np.zeros(len(drive)), (drive["kind"] == PID) & (drive["ki"] > 0.0)
    if measured.position is None or not gathers.any():
        return out
    missing = gathers
    if measured.effort is not None:
        rest = _beyond(plant, measured, commands, begin, gathers)
        missing = gathers & np.isnan(rest)
        out = np.where(gathers & ~missing, rest, 0.0)
    if missing.any():
        still = holding_effort(plant, measured.position[0] + drive["offset"])
        ahead = drive["kp"] * (commands.value[0] - measured.position[0])
        held = missing & (np.abs(ahead) <= np.abs(still))
        out[held] = (still - ahead)[held]
    return out


def _in_force(commands: Commands) -> int:
    """The number of the command that holds when a simulation begins."""
    return max(int(np.searchsorted(commands.time, 0.0, side="right")) - 1, 0)


def _beyond(plant: Plant, measured: Trace, commands: Commands, begin: float, gathers: NDArray[np.bool_]) -> Array:
    """What motors give beyond their proportional and damping part; NaN where that was not measured. Shape (n,)."""
    assert measured.position is not None
    assert measured.effort is not None
    drive, told = plant.drive, commands.value[:, gathers]
    same = (told == told[0]) | (np.isnan(told) & np.isnan(told[0]))  # NaN is a servo that is off
    later = np.flatnonzero(~same.all(axis=1))
    until = min(commands.time[later[0]] if later.size else np.inf, RECENT)
    first = slice(0, max(int(np.searchsorted(measured.time - begin, until)), 1))
    speed = np.zeros_like(measured.position) if measured.velocity is None else measured.velocity
    lag = commands.value[0] - measured.position[first]
    rest = measured.effort[first] - drive["kp"] * lag + drive["kd"] * speed[first]
    mean, error = rest.mean(axis=0), rest.std(axis=0) / np.sqrt(len(rest))
    return np.where(np.abs(mean) <= 3.0 * error, 0.0, mean)


def holding_effort(plant: Plant, position: Array) -> Array:
    """The effort [N·m or N] that holds a robot with a fixed base still at joint positions (n,). Shape (n,).

    The slope of the potential energy, less what acts already (a constant effort, a cable, a stop); 0 with a floating
    base, whose ground carries an unknown part.
    """
    model = plant.model
    if model.floating:
        return np.zeros(len(position))
    steps = SMALL * np.eye(len(position))
    slope = [_potential(plant, position + d) - _potential(plant, position - d) for d in steps]
    d = plant.drive
    past = np.minimum(position - d["stop_lower"], 0.0) + np.maximum(position - d["stop_upper"], 0.0)
    pull = d["constant"] - d["cable_stiffness"] * (position - d["cable_rest"]) - d["stop_stiffness"] * past
    effort: Array = np.array(slope) / (2 * SMALL) - pull
    return effort


def resting_twist(plant: Plant, commands: Commands, position: Array) -> Array:
    """By how much the rotors of a robot with a fixed base that rests at joint positions (n,) are ahead of their links
    [rad or m]: half the play, to the side to which the load pulls, or what the load twists a spring by. Shape (n,).

    0 where a rotor is rigid to its link, where the load is too small to have closed the play, where no servo holds the
    joint, as one that is off or told torques, and with a floating base.
    """
    drive = plant.drive
    own, stiff = (drive["kind"] != NONE) & (drive["meaning"] == POSITION), drive["stiffness"] > 0.0
    own &= (drive["armature"] > 0.0) & (stiff | (drive["backlash"] > 0.0))
    if not own.any():
        return np.zeros(len(drive))
    own &= np.isfinite(commands.value[_in_force(commands)])
    load = holding_effort(plant, position)
    closed = 0.5 * np.abs(load) / plant.inertia() * RESTED**2 > drive["backlash"]
    play = np.where(closed, 0.5 * np.sign(load) * drive["backlash"], 0.0)
    twist: Array = np.where(own, np.where(stiff, load / np.where(stiff, drive["stiffness"], 1.0), play), 0.0)
    return twist


def _potential(plant: Plant, position: Array) -> float:
    """The potential energy [J] of a robot with a fixed base at joint positions (n,)."""
    base, model = np.eye(4), plant.loaded()
    base[:3, :3] = _tilted(plant)
    poses = link_poses(model, position, base)
    return sum(
        link.mass * GRAVITY * float(pose[2, :3] @ link.com + pose[2, 3])
        for link, pose in zip(model.links, poses, strict=True)
    )


def _tilted(plant: Plant) -> Array:
    """The rotation of a fixed base. Shape (3, 3)."""
    roll, pitch = plant.base_tilt
    rotation: Array = rotation_from_rpy(roll, 0, 0) @ rotation_from_rpy(0, pitch, 0)
    return rotation


def _level(model: Model, position: Array, name: str) -> Array:
    """The rotation of the base that puts the sole of a link level; its heading is that of the base. Shape (3, 3)."""
    found = [i for i, link in enumerate(model.links) if name == link.name or name in link.merged]
    if not found:
        known = sorted(n for link in model.links for n in link.merged)
        raise InputError(f"robot.stand_on: found {name!r}; expected one of the links {', '.join(known)}")
    i = found[0]
    zero = link_poses(model, np.zeros(len(model.joints)))[i][:3, :3]
    now = link_poses(model, position)[i][:3, :3]
    points = np.array([s.center - zero.T @ [0, 0, s.radius] for s in model.links[i].spheres])
    zero = rotation_between(zero @ _upward(points, zero[2]), np.array([0.0, 0.0, 1.0])) @ zero
    rotation: Array = zero @ now.T
    yaw = np.arctan2(rotation[1, 0], rotation[0, 0])
    return rotation_from_rpy(0, 0, -yaw) @ rotation


def _upward(points: Array, up: Array) -> Array:
    """The normal, pointing into the link, of the sole of contact points (k, 3): the face of their hull that covers the
    most ground where `up` is up, which is roughly so with all joints at zero. `up` itself where there is no face.
    """
    if len(points) < 3:
        return up
    spread, axes = np.linalg.svd(points - points.mean(axis=0))[1:]
    if spread[-1] < SOLE or len(points) == 3:  # flat: the points are the sole
        normal = axes[2] if spread[1] > SOLE else up
        return normal if normal @ up > 0 else -normal
    hull = ConvexHull(points)
    corners = points[hull.simplices]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    normals = -hull.equations[:, :3]
    alike = normals @ normals.T > np.cos(FLAT)
    largest = int(np.argmax(alike @ area * (normals @ up)))
    normal = (area * alike[largest]) @ normals
    return np.asarray(normal / np.linalg.norm(normal))
