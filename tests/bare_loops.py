"""Bare loops over each engine: what a person would write for one of them, with its own calls.

They have the harness's control law and, where the engine lacks a part of the joint law, the same `law.joints`. They
read and record the same numbers.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from realitygap.robot.drive import LOG, STATE
from realitygap.robot.drive_law import drive_effort
from realitygap.robot.plant import Plant
from realitygap.simulate.commands import Commands, on_steps
from realitygap.simulate.start import start_state
from realitygap_engines import State
from realitygap_engines.model.robot import Array
from scipy.spatial.transform import Rotation

H = 1e-3


@dataclass
class Case:
    """A robot with its drives, and a motion."""

    name: str
    plant: Plant
    seconds: float

    def commands(self) -> Commands:
        """Slow sines of 0.1 rad, or of 0.5 rad where nothing can fall over."""
        t = np.arange(0.0, self.seconds, 0.01)
        n = len(self.plant.model.joints)
        wave = (0.1 if self.plant.model.floating else 0.5) * np.sin(2 * t)
        return Commands(t, np.tile(wave[:, None], (1, n)) * (np.arange(n) % 3 == 0))

    def start(self) -> State:
        return start_state(self.plant, np.zeros(len(self.plant.model.joints)))


class Tape:
    """What a bare loop needs and records: `q`, `w` and `dry` are Shape (t + 1, n), `base` is (t + 1, 13)."""

    def __init__(self, case: Case) -> None:
        n, self.steps = len(case.plant.model.joints), round(case.seconds / H)
        self.q, self.w = np.empty((self.steps + 1, n)), np.empty((self.steps + 1, n))
        self.base = np.zeros((self.steps + 1, 13))
        self.log, self.dry = np.zeros((self.steps + 1, n), LOG), np.zeros((self.steps + 1, n))
        self.command = on_steps(case.commands(), self.steps, H, case.plant.delay)
        self.effort, self.damping, self.friction = np.zeros(n), np.zeros(n), np.zeros(n)
        self.state = np.zeros(n, STATE)
        self.drive, self.inertia = case.plant.drive, case.plant.inertia()
        self.loaded = bool(self.drive["load"].any())

    def rows(self) -> "zip[tuple[Array, ...]]":
        """One step after the other: command, next command, q, w, dry friction, log; then q, w, base to be written."""
        after = np.vstack([self.command[1:], self.command[-1:]])
        q, w = self.q, self.w
        return zip(
            self.command, after, q, w, self.dry, self.log, q[1:], w[1:], self.base[1:], self.dry[1:], strict=False
        )


def mujoco_loop(simulation: Any, tape: Tape) -> None:
    import mujoco

    m, d = simulation._m, simulation._d
    n = tape.q.shape[1]
    o, p = m.nv - n, m.nq - n
    applied, dof_damping, dof_friction = d.qfrc_applied[o:], m.dof_damping[o:], m.dof_frictionloss[o:]
    qpos, qvel, pose, twist = d.qpos[p:], d.qvel[o:], d.qpos[:p], d.qvel[:o]
    drive, state, inertia = tape.drive, tape.state, tape.inertia
    effort, damping, friction, loaded = tape.effort, tape.damping, tape.friction, tape.loaded
    tape.q[0], tape.w[0] = qpos, qvel
    for k, (c, c1, qk, wk, dk, lk, q1, w1, b1, d1) in enumerate(tape.rows()):
        drive_effort(drive, state, c, c1, qk, wk, dk, inertia, 0.0, k * H, H, effort, damping, friction, lk)
        applied[:] = effort
        dof_damping[:] = damping
        dof_friction[:] = friction
        mujoco.mj_step(m, d)
        q1[:] = qpos
        w1[:] = qvel
        if o:
            b1[:7] = pose
            b1[7:] = twist
        if loaded:
            d1[:] = d.efc_force[:n]
    if o:  # MuJoCo's angular velocity is in the axes of the base
        tape.base[1:, 10:] = Rotation.from_quat(tape.base[1:, 3:7], scalar_first=True).apply(tape.base[1:, 10:])


def dart_loop(simulation: Any, tape: Tape) -> None:
    from realitygap_engines.dart import _quaternion_from_rotation_vector

    world, skeleton, law = simulation._world, simulation._skeleton, simulation._law
    n = tape.q.shape[1]
    o = skeleton.getNumDofs() - n
    forces = np.zeros(o + n)
    drive, state, inertia = tape.drive, tape.state, tape.inertia
    effort, damping, friction, loaded = tape.effort, tape.damping, tape.friction, tape.loaded
    b = simulation._base.copy()
    tape.q[0], tape.w[0] = skeleton.getPositions()[o:], skeleton.getVelocities()[o:]
    for k, (c, c1, qk, wk, dk, lk, q1, w1, b1, d1) in enumerate(tape.rows()):
        drive_effort(drive, state, c, c1, qk, wk, dk, inertia, 0.0, k * H, H, effort, damping, friction, lk)
        forces[o:] = law.effort(qk, wk, b, effort, damping, friction)
        if o and law.ballasted:
            forces[:3], forces[3:6] = law.wrench[3:], law.wrench[:3]
        skeleton.setForces(forces)
        world.step(False)
        position, velocity = skeleton.getPositions(), skeleton.getVelocities()
        q1[:] = position[o:]
        w1[:] = velocity[o:]
        if o:
            b = b1
            b[:3] = position[3:6]
            b[3:7] = _quaternion_from_rotation_vector(*position[:3].tolist())
            b[7:10] = velocity[3:6]
            b[10:] = velocity[:3]
        if loaded:
            d1[:] = law.dry


def drake_loop(simulation: Any, tape: Tape) -> None:
    plant, diagram, law = simulation._plant, simulation._diagram, simulation._law
    root, context = simulation._context, simulation._plant_context
    joints, update = simulation._joints, diagram.AllocateDiscreteVariables()
    inputs, qi, vi = simulation._inputs, simulation._q, simulation._v
    torque = simulation._actuation.GetMutableData().get_mutable_value().get_mutable_value()
    drive, state, inertia = tape.drive, tape.state, tape.inertia
    effort, damping, friction, loaded = tape.effort, tape.damping, tape.friction, tape.loaded
    b, o = simulation._base.copy(), plant.num_positions()
    floating = simulation.model.floating
    x = plant.GetPositionsAndVelocities(context)
    tape.q[0], tape.w[0] = x[qi], x[vi]
    damped = b""
    for k, (c, c1, qk, wk, dk, lk, q1, w1, b1, d1) in enumerate(tape.rows()):
        drive_effort(drive, state, c, c1, qk, wk, dk, inertia, 0.0, k * H, H, effort, damping, friction, lk)
        if damping.tobytes() != damped:
            for i, joint in enumerate(joints):
                joint.SetDampingVector(context, damping[i : i + 1])
            damped = damping.tobytes()
        torque = simulation._actuation.GetMutableData().get_mutable_value().get_mutable_value()
        torque[inputs] = law.effort(qk, wk, b, effort, damping, friction)
        diagram.CalcForcedDiscreteVariableUpdate(root, update)
        root.SetDiscreteState(update)
        x = plant.GetPositionsAndVelocities(context)
        q1[:] = x[qi]
        w1[:] = x[vi]
        if floating:
            b = b1
            b[:3] = x[4:7]
            b[3:7] = x[:4]
            b[7:10] = x[o + 3 : o + 6]
            b[10:] = x[o : o + 3]
        if loaded:
            d1[:] = law.dry


def pybullet_loop(simulation: Any, tape: Tape) -> None:
    import pybullet
    from realitygap_engines.model.quaternion import cross, product, rotate

    body, client, law = simulation._body, simulation._client, simulation._law
    n, com, back = tape.q.shape[1], simulation._com, simulation._from_principal
    joints, floating = list(range(n)), simulation.model.floating
    drive, state, inertia = tape.drive, tape.state, tape.inertia
    effort, damping, friction, loaded = tape.effort, tape.damping, tape.friction, tape.loaded
    b = simulation._base.copy()
    tape.q[0], tape.w[0] = simulation._position, simulation._velocity
    for k, (c, c1, qk, wk, dk, lk, q1, w1, b1, d1) in enumerate(tape.rows()):
        drive_effort(drive, state, c, c1, qk, wk, dk, inertia, 0.0, k * H, H, effort, damping, friction, lk)
        forces = law.effort(qk, wk, b, effort, damping, friction).tolist()
        pybullet.setJointMotorControlArray(body, joints, pybullet.TORQUE_CONTROL, forces=forces, physicsClientId=client)
        if floating and law.ballasted:
            wrench, at = law.wrench.tolist(), b[:3].tolist()
            pybullet.applyExternalForce(body, -1, wrench[:3], at, pybullet.WORLD_FRAME, physicsClientId=client)
            pybullet.applyExternalTorque(body, -1, wrench[3:], pybullet.WORLD_FRAME, physicsClientId=client)
        pybullet.stepSimulation(physicsClientId=client)
        states = pybullet.getJointStates(body, joints, physicsClientId=client)
        q1[:] = [s[0] for s in states]
        w1[:] = [s[1] for s in states]
        if floating:
            at, (x, y, z, w) = pybullet.getBasePositionAndOrientation(body, physicsClientId=client)
            linear, angular = pybullet.getBaseVelocity(body, physicsClientId=client)
            turn = product((w, x, y, z), back)
            arm = rotate(turn, com)
            swept = cross(angular, arm)
            b = b1
            b[:3] = at[0] - arm[0], at[1] - arm[1], at[2] - arm[2]
            b[3:7] = turn
            b[7:10] = linear[0] - swept[0], linear[1] - swept[1], linear[2] - swept[2]
            b[10:] = angular
        if loaded:
            d1[:] = law.dry


def ode_loop(simulation: Any, tape: Tape) -> None:
    from realitygap_engines.ode.library import CFM, FMAX, VEL
    from realitygap_engines.ode.robot import ode

    world, robot, contacts, advance = simulation._world, simulation._robot, simulation._contacts, simulation._advance
    armature, floating = simulation._armature.tolist(), simulation.model.floating
    rates: list[tuple[Any, float, int]] = []
    drive, state, inertia = tape.drive, tape.state, tape.inertia
    effort, damping, friction, loaded = tape.effort, tape.damping, tape.friction, tape.loaded
    set_damping = set_friction = b""
    seed = 0
    tape.q[0], tape.w[0] = simulation._position, simulation._velocity
    for k, (c, c1, qk, wk, dk, lk, q1, w1, b1, d1) in enumerate(tape.rows()):
        drive_effort(drive, state, c, c1, qk, wk, dk, inertia, 0.0, k * H, H, effort, damping, friction, lk)
        if damping.tobytes() != set_damping:
            rates = []
            for i, (joint, a, b) in enumerate(zip(robot.joints, armature, damping.tolist(), strict=True)):
                mass = a + H * b
                joint.set_motor(joint.rotor, FMAX, np.inf if mass > 0 else 0.0)
                joint.set_motor(joint.rotor, VEL, 0.0)
                if mass > 0:
                    joint.set_motor(joint.rotor, CFM, H / mass)
                if a > 0:
                    rates.append((joint, a / mass, i))
            set_damping = damping.tobytes()
        if friction.tobytes() != set_friction:
            for joint, bound in zip(robot.joints, friction.tolist(), strict=True):
                joint.set_motor(joint.brake, FMAX, bound)
            set_friction = friction.tobytes()
        for joint, given in zip(robot.joints, effort.tolist(), strict=True):
            joint.push(joint.joint, given)
        for joint, share, i in rates:
            joint.set_motor(joint.rotor, VEL, share * wk.item(i))
        if contacts is not None:
            contacts.make()
        ode.dRandSetSeed(seed)
        advance(world, H)
        seed = ode.dRandGetSeed()
        if contacts is not None:
            contacts.clear()
        q1[:] = qk  # angles go on from the last ones
        robot.read_joints(q1, w1)
        if floating:
            robot.read_base(b1)
        if loaded:
            d1[:] = robot.braking(friction.tolist())


def stepped_loop(simulation: Any, tape: Tape) -> None:
    """Of an engine that gives accelerations: its own calls are those of `_acceleration`."""
    from realitygap_engines.law.stepped import _advance

    law, accelerate, force, first = simulation._law, simulation._acceleration, simulation._force, simulation._first
    drive, state, inertia = tape.drive, tape.state, tape.inertia
    effort, damping, friction, loaded = tape.effort, tape.damping, tape.friction, tape.loaded
    q, w, b = simulation._position, simulation._velocity, simulation._base
    tape.q[0], tape.w[0] = q, w
    for k, (c, c1, qk, wk, dk, lk, q1, w1, b1, d1) in enumerate(tape.rows()):
        drive_effort(drive, state, c, c1, qk, wk, dk, inertia, 0.0, k * H, H, effort, damping, friction, lk)
        force[first:] = law.effort(q, w, b, effort, damping, friction)
        if first:
            force[:first] = law.wrench
        _advance(q, w, b, accelerate(force), H)
        q1[:] = q
        w1[:] = w
        if first:
            b1[:] = b
        if loaded:
            d1[:] = law.dry


LOOPS: dict[str, Callable[[Any, Tape], None]] = {
    "dart": dart_loop,
    "drake": drake_loop,
    "exudyn": stepped_loop,
    "mujoco": mujoco_loop,
    "ode": ode_loop,
    "pybullet": pybullet_loop,
    "simbody": stepped_loop,
}
