"""A humanoid on the ground, foreign to the diagnosis: MuJoCo moves the bodies, everything else is written here.

No contact, friction, limit or actuator of MuJoCo is used: feet touch the ground through springs and dampers at the
four outer corners of each sole, with Coulomb friction as brush bristles; joints by `drivetrain`.
"""

import os
from dataclasses import dataclass, field, replace
from pathlib import Path

import drivetrain
import mujoco
import numba
import numpy as np
from foreign import Foreign, Motion
from motions import Command
from servo import take_commands

STEP = 2e-4
RIGID = (2e5, 150.0)
"""Stiffness [N/m] and damping [N·s/m] per contact point of hard ground: it gives by 0.05 mm."""
FEET = ("left_foot___list_t0v6opd9rekumc_default", "right_foot_")
TORSO = "torso_2023"


def urdf() -> Path:
    """The humanoid's URDF in the data directory."""
    return Path(os.environ["REALITYGAP_DATA"]) / "sigmaban" / "robot.urdf"


@dataclass
class Ground:
    """Friction of the pair; stiffness [N/m] and damping [N·s/m] per contact point."""

    friction: float = 0.8
    stiffness: float = RIGID[0]
    damping: float = RIGID[1]


@dataclass
class Humanoid:
    """The humanoid: joints and sensors as a `Foreign` plant whose chain is unused, bodies by name."""

    plant: Foreign
    joints: list[str]
    ground: Ground = field(default_factory=Ground)
    mass: dict[str, float] = field(default_factory=dict)
    com: dict[str, np.ndarray] = field(default_factory=dict)

    def model(self) -> mujoco.MjModel:
        """Bodies and joints in MuJoCo, without contacts and limits."""
        spec = mujoco.MjSpec.from_file(str(urdf()))
        spec.compiler.discardvisual = False
        spec.worldbody.bodies[0].add_freejoint()
        for geom in spec.geoms:
            geom.contype = geom.conaffinity = 0
        for joint in spec.joints:
            if joint.name in self.joints:
                d = self.plant.drive[self.joints.index(joint.name)]
                joint.armature = 0.0 if d["backlash"] > 0 or d["stiffness"] > 0 else float(d["armature"])
                joint.frictionloss = joint.limited = 0
        for body in spec.bodies:
            if body.name in self.mass:
                body.mass = self.mass[body.name]
            if body.name in self.com:
                body.ipos = self.com[body.name]
        spec.option.timestep = STEP
        return spec.compile()


def joint_names() -> list[str]:
    """Joints that move, in the order of the model."""
    model = mujoco.MjSpec.from_file(str(urdf())).compile()
    return [model.joint(i).name for i in range(model.njnt)]


def body(name: str) -> tuple[float, np.ndarray]:
    """Mass and centre of mass of a link, as the team knows them."""
    model = mujoco.MjSpec.from_file(str(urdf())).compile()
    i = model.body(name).id
    return float(model.body_mass[i]), model.body_ipos[i].copy()


def soles(model: mujoco.MjModel) -> tuple[np.ndarray, np.ndarray]:
    """Foot bodies (2,) and contact points in their frames (2, 4, 3): outer edges of the four cleats."""
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    feet = np.array([model.body(name).id for name in FEET])
    points = np.zeros((2, 4, 3))
    for k, foot in enumerate(feet):
        cleats = [i for i in range(model.ngeom) if model.geom_bodyid[i] == foot and model.geom_type[i] == 5]
        centres = np.array([model.geom_pos[i] for i in cleats])
        corners = []
        for i, centre in zip(cleats, centres, strict=True):
            turn = np.zeros(9)
            mujoco.mju_quat2Mat(turn, model.geom_quat[i])
            axis = turn.reshape(3, 3)[:, 2]
            world = data.xmat[foot].reshape(3, 3)
            down = axis * np.sign(-(world @ axis)[2])
            outward = centre - centres.mean(axis=0)
            outward -= down * (down @ outward)
            side = model.geom_size[i, 0] * np.sign(np.round(outward, 4)) * np.sqrt(0.5)
            corners.append(centre + down * model.geom_size[i, 1] + side)
        points[k] = corners
    return feet, points


@numba.njit(cache=True)
def _ground(points, pos, mat, com, velocity, about, mu, stiffness, damping, anchor, touching, wrench):  # type: ignore[no-untyped-def]
    """Wrench (2, 6) on both feet at their centres of mass: force, torque, world axes."""
    shear, drag = 1e5, 60.0
    for f in range(2):
        wrench[f] = 0.0
        for k in range(4):
            p = pos[f] + mat[f] @ points[f, k]
            arm = p - about
            v = velocity[f, 3:] + np.cross(velocity[f, :3], arm)
            depth = -p[2]
            normal = max(0.0, stiffness * depth - damping * v[2]) if depth > 0.0 else 0.0
            if normal <= 0.0:
                touching[f, k] = False
                continue
            if not touching[f, k]:
                touching[f, k] = True
                anchor[f, k] = p[:2]
            force = np.zeros(3)
            force[2] = normal
            for i in range(2):
                force[i] = -shear * (p[i] - anchor[f, k, i]) - drag * v[i]
            size = np.hypot(force[0], force[1])
            if size > mu * normal:
                for i in range(2):
                    force[i] *= mu * normal / size
                    anchor[f, k, i] = p[i] + force[i] / shear
            wrench[f, :3] += force
            wrench[f, 3:] += np.cross(p - com[f], force)


def simulate(
    robot: Humanoid, sent: Command, duration: float, disturbance: np.ndarray | None = None, settle: float = 1.5
) -> tuple[Motion, np.ndarray]:
    """Stand at the first command for `settle` seconds, then play. Also returns the base's height. Shape (t,)."""
    model = robot.model()
    data = mujoco.MjData(model)
    n, plant = len(robot.joints), robot.plant
    drive = plant.drive.copy()
    feet, points = soles(model)
    data.qpos[7:] = sent.value[0] + drive["offset"]
    _stand(model, data, feet[0], points)
    times = sent.time + settle
    q, w = data.qpos[7:], data.qvel[6:]
    noise, state = np.zeros(n), drivetrain.at_rest(q, sent.value[0])
    anchor, touching, wrench = np.zeros((2, 4, 2)), np.zeros((2, 4), np.bool_), np.zeros((2, 6))
    rigid = np.array([not (d["backlash"] > 0 or d["stiffness"] > 0) for d in drive])
    soft = np.array([d["stiffness"] > 0 for d in drive])
    bus, steps = float(drive["supply"][0]), round((settle + duration) / STEP)
    out, height = np.zeros((4, steps + 1, n)), np.zeros(steps + 1)
    dead, off, on = plant.dropout
    ground = robot.ground
    for k in range(steps + 1):
        t = k * STEP
        take_commands(drive, state, times, sent.value, sent.enabled, t, settle, STEP)
        if dead >= 0 and off <= t - settle < on:
            state["live"][dead] = 0
        if disturbance is not None:
            noise[:] = disturbance[min(round(t / 1e-3), len(disturbance) - 1)]
        if plant.push is not None and t > settle:
            period = np.where(plant.push[:, 1] > 0, plant.push[:, 1], 1.0)
            noise += np.where((t - settle) % period < plant.push[:, 2], plant.push[:, 0], 0.0)
        mujoco.mj_step1(model, data)
        shaft = np.where(soft, state["rotor"], q)
        out[0, k], out[1, k], out[3, k] = shaft - drive["offset"], np.where(soft, state["rotor_w"], w), q
        height[k] = data.qpos[2]
        bus = drivetrain.joint_efforts(drive, state, plant.sag, plant.sag_law, bus, noise, t - settle, STEP, q, w)
        out[2, k] = state["motor"]
        data.qfrc_applied[6:] = state["applied"]
        _ground(
            points, data.xpos[feet], data.xmat[feet].reshape(2, 3, 3), data.xipos[feet], data.cvel[feet],
            data.subtree_com[1], ground.friction, ground.stiffness, ground.damping, anchor, touching, wrench,
        )  # fmt: skip
        data.xfrc_applied[feet] = wrench
        mujoco.mj_step2(model, data)
        state["link"] = np.where(rigid, state["applied"] - drive["armature"] * data.qacc[6:], state["link"])
        if disturbance is None:
            noise[:] = 0.0
    time = np.arange(steps + 1, dtype=np.float64) * STEP - settle
    keep = time >= -0.05
    return Motion(time[keep], *(x[keep] for x in out)), height[keep]


def _stand(model: mujoco.MjModel, data: mujoco.MjData, foot: int, points: np.ndarray) -> None:
    """Turn the base so that the left sole is level, and put the lowest point on the ground."""
    data.qpos[3:7] = (1, 0, 0, 0)
    mujoco.mj_kinematics(model, data)
    turn = data.xmat[foot].reshape(3, 3)
    corners = points[0] @ turn.T
    normal = np.linalg.svd(corners - corners.mean(axis=0))[2][2]
    normal *= np.sign(normal[2])
    axis = np.cross(normal, (0, 0, 1.0))
    angle = np.arctan2(np.linalg.norm(axis), normal[2])
    if angle > 1e-9:
        mujoco.mju_axisAngle2Quat(data.qpos[3:7], axis / np.linalg.norm(axis), angle)
    mujoco.mj_kinematics(model, data)
    lowest = min(
        float((data.xpos[b] + p @ data.xmat[b].reshape(3, 3).T)[:, 2].min())
        for b, p in zip([model.body(name).id for name in FEET], points, strict=True)
    )
    data.qpos[2] -= lowest


def copy(robot: Humanoid) -> Humanoid:
    """A humanoid that can be changed without changing this one."""
    plant = replace(
        robot.plant,
        drive=robot.plant.drive.copy(),
        velocity_time=robot.plant.velocity_time.copy(),
        velocity_scale=robot.plant.velocity_scale.copy(),
    )
    return replace(robot, plant=plant, ground=replace(robot.ground), mass=dict(robot.mass), com=dict(robot.com))
