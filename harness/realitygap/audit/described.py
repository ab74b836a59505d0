"""Mass and inertia of a robot as somebody else's reader has its file: Pinocchio's of a URDF, MuJoCo's own of a MJCF."""

from pathlib import Path

import numpy as np
from realitygap_engines.model.mjcf_file import compile_mjcf
from realitygap_engines.model.read import format_of
from realitygap_engines.model.robot import Array, Model

from realitygap.audit.oracle import urdf_inertia


def described_inertia(path: Path, model: Model, position: Array) -> tuple[float, Array, str]:
    """Mass [kg], joint-space inertia (n, n) without armature at joint positions (n,), and who says so.

    The base is held; its mass counts where the model's base floats.
    """
    if format_of(path) == "mjcf":
        return (*_mjcf_inertia(path, model, position), "MuJoCo's own model of the MJCF")
    return (*urdf_inertia(path, model, position), "Pinocchio's URDF reader")


def _mjcf_inertia(path: Path, model: Model, position: Array) -> tuple[float, Array]:
    import mujoco

    m = compile_mjcf(path)
    data = mujoco.MjData(m)
    joints = [m.joint(name) for name in model.joint_names]
    dofs = np.array([int(joint.dofadr[0]) for joint in joints], dtype=np.int64)
    for joint, q in zip(joints, position, strict=True):
        data.qpos[joint.qposadr] = q
    m.dof_armature[:] = 0.0
    if hasattr(m, "actuator_armature"):
        m.actuator_armature[:] = 0.0
    mujoco.mj_forward(m, data)
    inertia = np.zeros((m.nv, m.nv))
    mujoco.mj_fullM(m, data, inertia)
    moving = {int(joint.bodyid[0]) for joint in joints}
    whole = {b for b in range(m.nbody) if int(m.body_weldid[b]) in moving}
    if model.floating:  # its root, with or without a free joint in the file, and all that is fixed to it
        root = m.body(model.links[0].name).id
        whole |= {b for b in range(m.nbody) if int(m.body_rootid[b]) == root and int(m.body_weldid[b]) in (0, root)}
    return sum(float(m.body_mass[b]) for b in whole), inertia[np.ix_(dofs, dofs)]
