"""What the canonical model cannot say of a MJCF file: loops are refused, the rest is told."""

from pathlib import Path
from typing import Any

import numpy as np

from realitygap_engines.engine import GRAVITY
from realitygap_engines.errors import ModelError


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
