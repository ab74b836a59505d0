"""What the canonical model cannot say of a MJCF file: loops are refused, the rest is told."""

from pathlib import Path
from typing import Any

import numpy as np

from realitygap_engines.engine import GRAVITY
from realitygap_engines.errors import ModelError
from realitygap_engines.model.robot import Mimic


def refuse_loops(path: Path, m: Any, bodies: set[int]) -> None:
    """Make sure that no constraint closes a loop between bodies of the robot.

    Raises:
        ModelError: where one does.
    """
    import mujoco

    for i in range(m.neq):
        kind = mujoco.mjtEq(m.eq_type[i]).name
        if kind not in ("mjEQ_CONNECT", "mjEQ_WELD") or not m.eq_active0[i]:
            continue
        ends = [int(m.eq_obj1id[i]), int(m.eq_obj2id[i])]
        if m.eq_objtype[i] == mujoco.mjtObj.mjOBJ_SITE:
            ends = [int(m.site_bodyid[s]) for s in ends]
        if bodies & set(ends):
            names = " and ".join(m.body(e).name or "world" for e in ends)
            raise ModelError(
                f"{path}: the equality {kind[5:].lower()} between {names} closes a loop; expected a tree of joints"
            )


def read_mimics(path: Path, m: Any, joints: dict[int, str]) -> dict[str, Mimic]:
    """The linear couplings between joints of the robot, by the joint that follows; `joints`: MuJoCo's number -> name.

    Raises:
        ModelError: for a coupling that is not linear, or of one joint alone.
    """
    import mujoco

    out = {}
    for i in range(m.neq):
        if mujoco.mjtEq(m.eq_type[i]).name != "mjEQ_JOINT" or not m.eq_active0[i]:
            continue
        first, second = int(m.eq_obj1id[i]), int(m.eq_obj2id[i])
        if first not in joints:
            continue
        if second not in joints or np.any(m.eq_data[i, 2:5]):
            raise ModelError(
                f"{path}: the equality of joint {joints[first]} is no linear coupling with another joint of the robot; "
                "expected joint2, and polycoef with two numbers"
            )
        a0, a1 = (float(a) for a in m.eq_data[i, :2])
        own, other = (float(m.qpos0[m.jnt_qposadr[j]]) for j in (first, second))  # it counts from the reference pose
        out[joints[first]] = Mimic(joints[second], a1, own + a0 - a1 * other)
    return out


def losses(m: Any, bodies: set[int], joints: dict[int, str]) -> list[str]:
    """Sentences on what of the file is left out, apart from actuators; `joints`: MuJoCo's number -> name."""
    import mujoco

    notes = []
    for number, name in joints.items():
        dof = int(m.jnt_dofadr[number])
        stiffness, rest = float(m.jnt_stiffness[number]), float(m.qpos_spring[m.jnt_qposadr[number]])
        if stiffness:
            notes.append(f"joint {name}: its spring of {stiffness:g} per rad or m about {rest:g} is left out")
        poly = [getattr(m, "dof_dampingpoly", np.zeros((m.nv, 1)))[dof]]
        poly.append(getattr(m, "jnt_stiffnesspoly", np.zeros((m.njnt, 1)))[number])
        if any(np.any(p) for p in poly):
            notes.append(f"joint {name}: damping or stiffness that is not linear is left out")
    if any(float(m.body_gravcomp[b]) for b in bodies):
        notes.append("gravity compensation (gravcomp) is left out")
    kinds = [mujoco.mjtEq(m.eq_type[i]).name for i in range(m.neq) if m.eq_active0[i]]
    others = sorted({k[5:].lower() for k in kinds} - {"connect", "weld", "joint"})
    if others:
        notes.append(f"equality constraints of {', '.join(others)} are left out")
    if m.ntendon and (np.any(m.tendon_stiffness) or np.any(m.tendon_damping) or np.any(m.tendon_limited)):
        notes.append("springs, damping and limits of tendons are left out")
    if m.opt.density or m.opt.viscosity:
        notes.append("the fluid (density, viscosity) is left out")
    if not np.allclose(m.opt.gravity, (0, 0, -GRAVITY)):
        found = " ".join(f"{g:g}" for g in m.opt.gravity)
        notes.append(f"the file's gravity is {found} m/s²; simulated with {GRAVITY} m/s² down")
    return notes
