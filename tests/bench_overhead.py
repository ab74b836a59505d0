"""What the harness costs: its time loop against a bare loop over the same engine, and a full servo against a plain one.

The bare loops are what a person would write for one engine: its own calls, the same control law and, where the engine
lacks a part of the joint law, the same `law.joints`; they read and record the same numbers. Each batch runs a
bare motion and then the harness's, and the least time of each counts, so that a busy machine shows least.

    python tests/bench_overhead.py [--batches 7] [--write results/reference/overhead.csv]
"""

import argparse
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import realitygap_engines as engines
from realitygap.robot.drive import DC, LOG, PID, STATE, neutral_drive
from realitygap.robot.drive_law import drive_effort
from realitygap.robot.plant import Plant
from realitygap.simulate.commands import Commands, on_steps
from realitygap.simulate.rollout import rollout
from realitygap.simulate.start import start_state
from realitygap_engines import Ground, Physics, State
from realitygap_engines.model.robot import Array, Joint, Link, Model, Sphere
from scipy.spatial.transform import Rotation

H = 1e-3
SERVO = {"torque_constant": 2.19, "resistance": 2.96, "supply": 15.0, "gain": 5.056, "duty_limit": 0.9625}
FRICTION = {"static": 0.15, "coulomb": 0.1, "stribeck_velocity": 0.2, "viscous": 0.035, "load": 0.05}


def pendulum() -> Model:
    base = Link("base", 1.0, np.zeros(3), np.eye(3) * 1e-3)
    bob = Link("bob", 0.5, np.array([0.0, 0.0, -0.1]), np.eye(3) * 1e-4)
    return Model("pendulum", (base, bob), (Joint("hinge", False, 0, np.eye(4), np.array([0.0, 1.0, 0.0])),), False)


def humanoid() -> Model:
    """Twenty joints, 6.2 kg, on two feet of four corner spheres each."""
    links = [Link("torso", 2.4, np.array([0.0, 0.0, 0.08]), np.diag([0.02, 0.015, 0.012]))]
    joints: list[Joint] = []

    def add(name: str, parent: int, at: tuple[float, float, float], axis: int, mass: float, drop: float) -> int:
        origin = np.eye(4)
        origin[:3, 3] = at
        joints.append(Joint(name, False, parent, origin, np.eye(3)[axis]))
        links.append(
            Link(name, mass, np.array([0.0, 0.0, -drop / 2]), np.diag([1.0, 1.0, 0.5]) * max(mass, 0.1) * 2e-3)
        )
        return len(links) - 1

    for side, y in (("left", 0.06), ("right", -0.06)):
        yaw = add(f"{side}_hip_yaw", 0, (0, y, -0.02), 2, 0.1, 0.02)
        roll = add(f"{side}_hip_roll", yaw, (0, 0, -0.02), 0, 0.2, 0.02)
        pitch = add(f"{side}_hip_pitch", roll, (0, 0, 0), 1, 0.45, 0.15)
        knee = add(f"{side}_knee", pitch, (0, 0, -0.15), 1, 0.3, 0.15)
        ankle = add(f"{side}_ankle_pitch", knee, (0, 0, -0.15), 1, 0.1, 0.02)
        foot = add(f"{side}_ankle_roll", ankle, (0, 0, -0.02), 0, 0.25, 0.03)
        corners = [Sphere(np.array([x, s * 0.04, -0.03]), 1e-3) for x in (-0.08, 0.1) for s in (-1, 1)]
        links[foot] = replace(links[foot], spheres=tuple(corners))
        shoulder = add(f"{side}_shoulder_pitch", 0, (0, 2 * y, 0.15), 1, 0.15, 0.02)
        arm = add(f"{side}_shoulder_roll", shoulder, (0, 0, 0), 0, 0.2, 0.12)
        add(f"{side}_elbow", arm, (0, 0, -0.12), 1, 0.15, 0.12)
    neck = add("head_yaw", 0, (0, 0, 0.2), 2, 0.1, 0.02)
    add("head_pitch", neck, (0, 0, 0.04), 1, 0.3, -0.05)
    return Model("humanoid", tuple(links), tuple(joints), True)


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


def case(model: Model, seconds: float, *, servo: bool) -> Case:
    """The robot with a plain PID on every joint, or a dc servo with Stribeck, viscous and load-dependent friction."""
    n = len(model.joints)
    drive = neutral_drive(n)
    if servo:
        drive["kind"], drive["armature"] = DC, 0.0266
        for name, value in (SERVO | FRICTION).items():
            drive[name] = value
    else:
        drive["kind"], drive["kp"], drive["kd"] = PID, 30.0, 0.3
    ground = Ground() if model.floating else None
    plant = Plant(model, drive, ground, np.zeros(n), np.zeros(n), np.ones(n), np.zeros(2))
    return Case(model.name, plant, seconds)


class Tape:
    """What a bare loop needs and records."""

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


LOOPS: dict[str, Callable[[Any, Tape], None]] = {
    "dart": dart_loop,
    "drake": drake_loop,
    "mujoco": mujoco_loop,
    "pybullet": pybullet_loop,
}


def timed(run: Callable[[], object]) -> float:
    """Processor seconds: another process on the same core does not count."""
    begin = time.process_time()
    run()
    return time.process_time() - begin


def measure(name: str, model: Model, seconds: float, batches: int) -> dict[str, float | str]:
    """Microseconds per step of the bare loop and of the harness, each with a plain PID and with the full servo."""
    best: dict[str, float] = {}
    cases = {"pid": case(model, seconds, servo=False), "servo": case(model, seconds, servo=True)}
    opened = {
        k: engines.load(name).open(c.plant.machine(), Physics(H, ground=c.plant.ground)) for k, c in cases.items()
    }
    for _ in range(batches + 1):  # the first one warms up
        for kind, c in cases.items():
            simulation, start, commands = opened[kind], c.start(), c.commands()

            def bare(c: Case = c, simulation: engines.Simulation = simulation, start: State = start) -> Tape:
                tape = Tape(c)
                simulation.reset(start)
                LOOPS[name](simulation, tape)
                return tape

            def harness(
                c: Case = c, s: engines.Simulation = simulation, start: State = start, told: Commands = commands
            ) -> object:
                return rollout(s, c.plant, told, start, c.seconds)

            for key, run in ((f"bare_{kind}", bare), (f"harness_{kind}", harness)):
                best[key] = min(best.get(key, np.inf) if _ else np.inf, timed(run) / round(c.seconds / H) * 1e6)
    assert_same(cases["pid"], opened["pid"], name)
    for simulation in opened.values():
        simulation.close()
    return {
        "engine": name,
        "robot": model.name,
        **{key: round(value, 2) for key, value in best.items()},
        "overhead_pid": round(best["harness_pid"] / best["bare_pid"] - 1, 3),
        "overhead_servo": round(best["harness_servo"] / best["bare_servo"] - 1, 3),
        "servo_rate": round(best["harness_pid"] / best["harness_servo"], 3),
    }


def assert_same(c: Case, simulation: engines.Simulation, name: str) -> None:
    """The two loops did the same: their joint positions agree to the last bit but few."""
    tape = Tape(c)
    simulation.reset(c.start())
    LOOPS[name](simulation, tape)
    found = rollout(simulation, c.plant, c.commands(), c.start(), c.seconds).trace.position
    assert found is not None
    np.testing.assert_allclose(found, tape.q[: len(found)], rtol=0, atol=1e-9)


def law(repeats: int = 20, calls: int = 1000) -> dict[str, float]:
    """Microseconds per call of the control law for twenty joints, plain and full."""
    out = {}
    for kind, servo in (("pid", False), ("servo", True)):
        tape = Tape(case(humanoid(), 0.1, servo=servo))
        tape.q[:], tape.w[:] = 0.05, 0.1
        c, c1, q, w, dry, log, *_ = next(iter(tape.rows()))

        def run(tape: Tape = tape, row: tuple[Array, ...] = (c, c1, q, w, dry), log: Array = log) -> None:
            for _ in range(calls):
                drive_effort(
                    tape.drive, tape.state, *row, tape.inertia, 0.0, 0.0, H,
                    tape.effort, tape.damping, tape.friction, log,
                )  # fmt: skip

        run()
        out[kind] = min(timed(run) for _ in range(repeats)) / calls * 1e6
    return out


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--batches", type=int, default=7)
    parser.add_argument("--engine", action="append", choices=sorted(LOOPS))
    parser.add_argument("--write", type=Path, help="also write the table to this file")
    options = parser.parse_args()
    rows = [
        measure(name, model, seconds, options.batches)
        for name in options.engine or sorted(set(LOOPS) & set(engines.available()))
        for model, seconds in ((pendulum(), 5.0), (humanoid(), 1.0))
    ]
    found = pd.DataFrame(rows)
    print("Microseconds per step; overhead of the harness over the bare loop; rate of the full servo over plain PID:")
    print(found.to_string(index=False))
    print("Control law, twenty joints, µs per step:", {k: round(v, 2) for k, v in law().items()})
    if options.write:
        found.to_csv(options.write, index=False)


if __name__ == "__main__":
    main()
