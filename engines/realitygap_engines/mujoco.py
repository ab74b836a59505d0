"""MuJoCo: generalized coordinates, convex soft-constraint contact solved by Newton's method.

How it solves: the `discrete` integrator merges the constraint solve and the implicit velocity update in the metric
M + h·D, so that damping stays consistent with contact. Armature and joint damping are native; dry friction is a
soft constraint that creeps (about 1e-5 rad/s at 85 % of breakaway with the settings below).
Where it lies by default: the root is welded and fused, small inertias are lifted, URDF effort clamps, a blow-up
resets the state, contact friction is the larger of the pair. All of that is switched off here.
"""

import weakref
from functools import cached_property
from importlib.metadata import version
from typing import Any

import mujoco
import numpy as np

from realitygap_engines.engine import Capability, Engine, Ground, Native, Physics, Simulation, State
from realitygap_engines.errors import Diverged
from realitygap_engines.law.mimic import MIMIC_JOINTS, coupled
from realitygap_engines.model.robot import Array, Model, quaternion_from_rotation, rotation_from_quaternion
from realitygap_engines.mujoco_steps import (
    INVERSE,
    STEP,
    c_functions,
    clock,
    force_word,
    inverse,
    read_base,
    read_bases,
    undamp,
    word,
)

FRICTION_SOLREF = (0.002, 1.0)
FRICTION_SOLIMP = (0.9999, 0.9999, 0.001, 0.5, 2.0)
RIGID_SOLIMP = (0.99, 0.99, 0.001, 0.5, 2.0)
LIMIT_SOLIMP = (0.95, 0.99, 0.001, 0.5, 2.0)
IMPRATIO = 100.0
SOFT_IMPRATIO = 1e3


class _Silence:
    """No messages of MuJoCo, and no looks at the clock, while one of our simulations is open; then all is as before.

    A blow-up is the caller's to report; MuJoCo would print it and write MUJOCO_LOG.TXT into the working folder. The
    times of its parts of a step (`mjData.timer`) are not told; nothing else comes of its clock.
    """

    def __init__(self) -> None:
        self._open = 0
        self._before: Any = None
        self._clock: int | None = None

    def begin(self) -> None:
        if self._open == 0:
            self._before = mujoco.get_mju_user_warning()
            mujoco.set_mju_user_warning(lambda _: None)
            if (asked := clock()) is not None:
                self._clock, asked.value = asked.value, None
        self._open += 1

    def end(self) -> None:
        self._open -= 1
        if self._open == 0:
            mujoco.set_mju_user_warning(self._before)
            if (asked := clock()) is not None:
                asked.value = self._clock


SILENCE = _Silence()


class MujocoSimulation(Simulation):
    """One `mjModel` with its `mjData`. See `Simulation`."""

    def __init__(self, model: Model, physics: Physics) -> None:
        self.model = model
        self.physics = physics
        SILENCE.begin()
        self._end_silence = weakref.finalize(self, SILENCE.end)  # once, also where nobody closes it
        spec = build_spec(model, physics)
        self._m = m = spec.compile()
        self._d = d = mujoco.MjData(m)
        self._offset = o = 6 if model.floating else 0
        self._soft = physics.ground is not None and physics.ground.stiffness is not None
        if self._soft and physics.ground is not None:
            soften(m, physics.ground)
        self._applied = d.qfrc_applied[o:]
        self._damping = m.dof_damping[o:]
        self._friction = m.dof_frictionloss[o:]
        p = 7 if model.floating else 0
        self._qpos, self._qvel = d.qpos[p:], d.qvel[o:]
        self._base_pose, self._base_velocity = d.qpos[:p], d.qvel[:o]
        self._n = len(model.joints)
        self._zero = State(np.zeros(self._n), np.zeros(self._n))
        option = m.opt
        self.settings = {
            "integrator": mujoco.mjtIntegrator(option.integrator).name,
            "solver": mujoco.mjtSolver(option.solver).name,
            "iterations": option.iterations,
            "tolerance": option.tolerance,
            "cone": mujoco.mjtCone(option.cone).name,
            "impratio": option.impratio,
            "timestep": option.timestep,
            "autoreset": "off",
            "islands": "off",
            "fusestatic": "off",
            "boundmass, boundinertia, balanceinertia": "off",
            "solref_friction": FRICTION_SOLREF,
            "contact pair friction": None if physics.ground is None else physics.ground.friction,
        }
        self.reset(self._zero)

    def reset(self, state: State) -> None:
        m, d = self._m, self._d
        mujoco.mj_resetData(m, d)
        self._qpos[:] = state.position
        self._qvel[:] = state.velocity
        if self.model.floating:
            d.qpos[:3] = state.base_position
            d.qpos[3:7] = state.base_quaternion
            d.qvel[:3] = state.base_linear
            d.qvel[3:6] = rotation_from_quaternion(state.base_quaternion).T @ state.base_angular
        else:
            m.body_pos[1] = state.base_position
            m.body_quat[1] = state.base_quaternion
        self._damping[:] = 0.0
        self._friction[:] = 0.0
        mujoco.mj_forward(m, d)

    def step(self, effort: Array, damping: Array, friction: Array) -> None:
        self._applied[:] = effort
        self._damping[:] = damping
        self._friction[:] = friction
        m, d = self._m, self._d
        if self._soft:
            mujoco.mj_step1(m, d)
            if d.ncon:
                contact, diagonal = d.contact, m.M_rowadr + m.M_rownnz
                undamp(
                    d.efc_J, contact.efc_address, d.M, diagonal, m.dof_damping, self.physics.timestep, contact.solref
                )
            mujoco.mj_step2(m, d)
        else:
            mujoco.mj_step(m, d)

    def read(self, position: Array, velocity: Array, base: Array) -> None:
        position[:] = self._qpos
        velocity[:] = self._qvel
        if self._offset:
            read_base(self._base_pose, self._base_velocity, base)

    def native(self) -> Native | None:
        functions, force = c_functions(*STEP), force_word()
        if self._soft or functions is None or force is None:  # on soft ground contacts are changed amid a step
            return None
        return Native(
            functions, self._m._address, self._d._address, self._applied, self._damping, self._friction,
            self._qpos, self._qvel, (self._base_pose, self._base_velocity), read_bases,
            word(self._d, force),
        )  # fmt: skip

    def dry_friction(self) -> Array:
        d, n = self._d, self._n
        if d.nf == n:  # a row for every joint, in their order, before those of limits and contacts
            force: Array = d.efc_force[:n]
            return force
        out = np.zeros(n)
        out[d.efc_id[: d.nf] - self._offset] = d.efc_force[: d.nf]
        return out

    def mass_matrix(self) -> Array:
        m, d = self._m, self._d
        mujoco.mj_forward(m, d)
        full = np.zeros((m.nv, m.nv))
        mujoco.mj_fullM(m, d, full)
        return self._to_world(full)

    def bias(self) -> Array:
        mujoco.mj_forward(self._m, self._d)
        return self._to_world(self._d.qfrc_bias.copy())

    def _inverse(self, start: State, position: Array, velocity: Array, acceleration: Array) -> Array:
        m, d, out = self._m, self._d, np.empty_like(position)
        self.reset(start)
        motion = [np.ascontiguousarray(value) for value in (position, velocity, acceleration)]
        functions = c_functions(*INVERSE)
        if functions is not None:
            inverse(functions, m._address, d._address, self._qpos, self._qvel, d.qacc, *motion, out)
            return out
        for k in range(len(position)):
            self._qpos[:], self._qvel[:], d.qacc[:] = (value[k] for value in motion)
            for name in INVERSE[:-1]:
                getattr(mujoco, name)(m, d)
            mujoco.mj_rne(m, d, 1, out[k])
        return out

    def close(self) -> None:
        self._end_silence()

    def _to_world(self, local: Array) -> Array:
        """From MuJoCo's local angular velocity of the base to world axes."""
        if self._offset:
            r = rotation_from_quaternion(self._d.qpos[3:7])
            local[3:6] = r @ local[3:6]
            if local.ndim == 2:
                local[:, 3:6] = local[:, 3:6] @ r.T
        return local


def build_spec(model: Model, physics: Physics) -> "mujoco.MjSpec":
    spec = mujoco.MjSpec()
    spec.compiler.fusestatic = False
    spec.compiler.boundmass = 0.0
    spec.compiler.boundinertia = 0.0
    spec.compiler.balanceinertia = False
    spec.compiler.inertiafromgeom = mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_FALSE
    spec.compiler.degree = False
    spec.compiler.autolimits = False
    option = spec.option
    option.timestep = physics.timestep
    option.gravity = physics.gravity
    option.integrator = mujoco.mjtIntegrator.mjINT_DISCRETE
    option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    option.impratio = IMPRATIO
    off = mujoco.mjtDisableBit  # a robot is one island, and would be found to be one in every step
    option.disableflags = int(off.mjDSBL_AUTORESET) | int(off.mjDSBL_ISLAND)
    option.tolerance = 1e-12
    if physics.solver_iterations is not None:
        option.iterations = physics.solver_iterations
    ground = physics.ground
    soft = ground is not None and ground.stiffness is not None
    if soft:
        option.impratio = SOFT_IMPRATIO
        option.jacobian = mujoco.mjtJacobian.mjJAC_DENSE  # as `undamp` reads it
    if ground is not None:
        spec.worldbody.add_geom(
            name="ground", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0, 0, 1], contype=0 if soft else 1, conaffinity=0
        )
    bodies: list[Any] = []
    for i, link in enumerate(model.links):
        joint = model.joints[i - 1] if i else None
        if joint is None:
            # MuJoCo has a body "world" of its own, and a URDF's root is often called that too
            body = spec.worldbody.add_body(name="world link" if link.name == "world" else link.name)
            if model.floating:
                body.add_freejoint()
        else:
            body = bodies[joint.parent].add_body(
                name=link.name,
                pos=joint.origin[:3, 3],
                quat=quaternion_from_rotation(joint.origin[:3, :3]),
            )
            limited = np.isfinite(joint.lower) or np.isfinite(joint.upper)
            body.add_joint(
                name=joint.name,
                type=mujoco.mjtJoint.mjJNT_SLIDE if joint.prismatic else mujoco.mjtJoint.mjJNT_HINGE,
                axis=joint.axis,
                armature=joint.armature,
                limited=limited,
                range=[max(joint.lower, -1e6), min(joint.upper, 1e6)],
                solref_limit=[2 * physics.timestep, 1.0],
                solimp_limit=LIMIT_SOLIMP,
                solref_friction=FRICTION_SOLREF,
                solimp_friction=FRICTION_SOLIMP,
            )
        body.explicitinertial = True
        body.mass = link.mass
        body.ipos = link.com
        t = link.inertia
        body.fullinertia = [t[0, 0], t[1, 1], t[2, 2], t[0, 1], t[0, 2], t[1, 2]]
        bodies.append(body)
        if ground is None or not (i or model.floating):
            continue  # nothing of it touches the ground
        for k, sphere in enumerate(link.spheres):
            body.add_geom(
                name=f"{link.name} {k}",
                type=mujoco.mjtGeom.mjGEOM_SPHERE,
                size=[sphere.radius, 0, 0],
                pos=sphere.center,
                contype=0,  # the robot touches the ground only, not itself
                conaffinity=0 if soft else 1,
                mass=0,
                priority=1,  # its friction and compliance win over the plane's
                condim=3,
                friction=[ground.friction, 0, 0],
                solref=[2 * physics.timestep, 1.0],
                solimp=RIGID_SOLIMP,
            )
            if soft:  # an explicit pair, because only that holds friction otherwise than it presses
                spec.add_pair(
                    geomname1="ground",
                    geomname2=f"{link.name} {k}",
                    condim=3,
                    friction=[ground.friction, ground.friction, 0, 0, 0],
                    solreffriction=[2 * physics.timestep, 1.0],
                )
    return spec


def soften(m: "mujoco.MjModel", ground: Ground) -> None:
    """The stiffness k and damping b of a contact point, as implicit Euler of `max(0, -k·z - b·z')`.

    A contact row of impedance d presses with (-K·z - B·z' - z'')/R, R = A·(1 - d)/d, where solref holds -K·d and -B·d
    and A is the inverse inertia that MuJoCo ascribes to it: `body_invweight0` of the sphere's body alone, since the
    ground has none. So K = k·R and B = b·R, and the least d there is leaves next to nothing of the last term.
    """
    d = mujoco.mjMINIMP
    for i, sphere in enumerate(m.pair_geom2):
        scale = (1 - d) * float(m.body_invweight0[m.geom_bodyid[sphere], 0])
        m.pair_solref[i] = (-(ground.stiffness or 0.0) * scale, -(ground.damping or 0.0) * scale)
        m.pair_solimp[i] = (d, d, 0.001, 0.5, 2.0)


class MujocoEngine(Engine):
    """MuJoCo. See `Engine`."""

    name = "mujoco"

    @cached_property
    def version(self) -> str:
        return version("mujoco")

    def capabilities(self) -> dict[str, Capability]:
        return {
            "armature": Capability("native", "dof_armature"),
            "forward_dynamics": Capability("native", "generalized coordinates"),
            "joint_damping": Capability("native", "dof_damping, implicit in the discrete integrator"),
            "joint_friction": Capability("native", "dof_frictionloss; creeps about 1e-5 rad/s at 85 % of breakaway"),
            "joint_limits": Capability("native", "soft limits with a time constant of two steps"),
            "lone_body": Capability(
                "no", "its gyroscopic torque is the one at the end of the step: an error of order h"
            ),
            "mimic_joints": MIMIC_JOINTS,
            "rigid_ground": Capability("native", "elliptic cones, soft with a time constant of two steps"),
            "soft_ground": Capability("native", "solref from stiffness and damping"),
            "solver_iterations": Capability("native", "Newton iterations, at most"),
        }

    def open(self, model: Model, physics: Physics) -> Simulation:
        return coupled(MujocoSimulation(model, physics))


ENGINE = MujocoEngine()
__all__ = ["ENGINE", "Diverged", "MujocoEngine", "MujocoSimulation"]
