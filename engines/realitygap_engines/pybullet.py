"""PyBullet: generalized coordinates (articulated-body algorithm), contact by projected Gauss-Seidel with cones.

How it solves: free acceleration first, then contact and limit impulses in sweeps, then positions from the new
velocities. It has no armature and its joint damping and friction are explicit or motors, so that all three come from
`law.joints`.
Where it lies by default: a velocity motor on every joint, damping of links, a speed limit of 100, a residual at which
the sweeps end whatever their number, inertias from collision shapes, one cached file per path, sleeping, the base's
centre of mass in place of its frame, friction of a pair as the product. All of that is switched off or undone here.
"""

import tempfile
from contextlib import closing
from dataclasses import replace
from functools import cached_property
from importlib.metadata import version
from math import hypot
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from realitygap_engines.engine import Capability, Engine, Physics, Simulation, State
from realitygap_engines.law.joints import JointLaw
from realitygap_engines.law.mimic import MIMIC_JOINTS, coupled
from realitygap_engines.law.runaway import RUNAWAY, diverged
from realitygap_engines.model.quaternion import Vector, cross, product, rotate
from realitygap_engines.model.quiet import unprinted
from realitygap_engines.model.robot import Array, Model, quaternion_from_rotation, rotation_from_quaternion
from realitygap_engines.model.urdf import rpy_from_rotation, write_urdf

with unprinted(2):  # its C code greets on the standard error at import
    import pybullet

FREE = 1e9
"""In place of a limit that does not exist: of a joint's position and speed."""
SMOOTH = {"rollingFriction": 0.0, "spinningFriction": 0.0, "restitution": 0.0}
ITERATIONS = 100
"""Sweeps of the contact solver where none are asked for. With Bullet's 50 a humanoid whose joints have dry friction is
1e-3 rad from where 100 and more put it."""


class PybulletSimulation(Simulation):
    """One physics client with one body and the ground. See `Simulation`."""

    def __init__(self, model: Model, physics: Physics) -> None:
        self.model = model
        self.physics = physics
        n = len(model.joints)
        self._law = JointLaw(model, physics, native_armature=False, native_damping=False, ballast=True)
        self._client, self._body = _open(self._law.model, physics)
        self._joints = list(range(n))
        self._joint_state, self._base = np.zeros(2 * n), np.zeros(13)
        self._position, self._velocity = self._joint_state[:n], self._joint_state[n:]
        self._pushed = model.floating and self._law.ballasted
        info = pybullet.getDynamicsInfo(self._body, -1, physicsClientId=self._client)
        # Bullet's frame of the base is in the centre of mass, along the principal axes
        x, y, z, w = info[4]
        self._com: Vector = info[3]
        self._principal = rotation_from_quaternion(np.array([w, x, y, z]))
        self._from_principal = (w, -x, -y, -z)
        self._untouched = pybullet.saveState(physicsClientId=self._client)
        self.settings = _settings(self._client, physics)
        self.settings["ballast for armature"] = self._law.ballasted
        self.settings["armature, damping, dry friction"] = "emulated by realitygap_engines.law.joints"
        self.settings["limits enforced"] = [j.name for j in model.joints if _limited(j.lower, j.upper)]
        self.reset(State(np.zeros(n), np.zeros(n)))

    def reset(self, state: State) -> None:
        body, client = self._body, self._client
        pybullet.restoreState(self._untouched, physicsClientId=client)  # without contacts and warm starts
        turn = rotation_from_quaternion(state.base_quaternion)
        arm = turn @ self._com
        w, x, y, z = quaternion_from_rotation(turn @ self._principal).tolist()
        pybullet.resetBasePositionAndOrientation(
            body, (state.base_position + arm).tolist(), (x, y, z, w), physicsClientId=client
        )
        if self.model.floating:
            linear = state.base_linear + np.cross(state.base_angular, arm)
            pybullet.resetBaseVelocity(body, linear.tolist(), state.base_angular.tolist(), physicsClientId=client)
        for i, (q, v) in enumerate(zip(state.position.tolist(), state.velocity.tolist(), strict=True)):
            pybullet.resetJointState(body, i, q, v, physicsClientId=client)
        self._base[:3], self._base[3:7] = state.base_position, state.base_quaternion
        self._law.reset()
        self._steps = 0
        self._fetch()

    def step(self, effort: Array, damping: Array, friction: Array) -> None:
        body, client = self._body, self._client
        effort = self._law.effort(self._position, self._velocity, self._base, effort, damping, friction)
        self._steps += 1
        if self._joints:
            forces = effort.tolist()
            pybullet.setJointMotorControlArray(
                body, self._joints, pybullet.TORQUE_CONTROL, forces=forces, physicsClientId=client
            )
        if self._pushed:
            wrench = self._law.wrench.tolist()
            origin, world = self._base[:3].tolist(), pybullet.WORLD_FRAME
            pybullet.applyExternalForce(body, -1, wrench[:3], origin, world, physicsClientId=client)
            pybullet.applyExternalTorque(body, -1, wrench[3:], world, physicsClientId=client)
        pybullet.stepSimulation(physicsClientId=client)
        self._fetch()

    def _fetch(self) -> None:
        body, client = self._body, self._client
        speed = 0.0
        if self._joints:
            states = pybullet.getJointStates(body, self._joints, physicsClientId=client)
            position, velocity, *_ = zip(*states, strict=True)
            self._joint_state[:] = position + velocity
            speed = hypot(*velocity)
        if self.model.floating:
            com, (x, y, z, w) = pybullet.getBasePositionAndOrientation(body, physicsClientId=client)
            linear, angular = pybullet.getBaseVelocity(body, physicsClientId=client)
            turn = product((w, x, y, z), self._from_principal)
            arm = rotate(turn, self._com)
            swept = cross(angular, arm)
            self._base[:] = (
                *(com[0] - arm[0], com[1] - arm[1], com[2] - arm[2]),
                *turn,
                *(linear[0] - swept[0], linear[1] - swept[1], linear[2] - swept[2]),
                *angular,
            )
            speed += hypot(*linear, *angular)
        if not speed < RUNAWAY:
            # Bullet removes what leaves its world and goes on
            raise diverged(self.model, self._steps * self.physics.timestep, self._velocity, "velocity runs away")

    def read(self, position: Array, velocity: Array, base: Array) -> None:
        position[:] = self._position
        velocity[:] = self._velocity
        if self.model.floating:
            base[:] = self._base

    def dry_friction(self) -> Array:
        return self._law.dry

    def mass_matrix(self) -> Array:
        n = len(self._joints)
        if n:
            found = pybullet.calculateMassMatrix(self._body, self._position.tolist(), physicsClientId=self._client)
            found = np.array(found)
        else:  # which Bullet does not answer for a single body
            info = pybullet.getDynamicsInfo(self._body, -1, physicsClientId=self._client)
            found = np.diag([*info[2], *[info[0]] * 3])
        if self.model.floating:
            found = self._turn(found, n)
        ballast: Array = found - self._law.ballast(self._position, self._velocity, self._base)[0]
        return ballast

    def _turn(self, found: Array, n: int) -> Array:
        """From Bullet's base coordinates: angular first, both in its frame and about the centre of mass."""
        link = rotation_from_quaternion(self._base[3:7])
        frame = (link @ self._principal).T
        x, y, z = link @ self._com
        to_bullet = np.eye(6 + n)
        to_bullet[:6, :6] = 0.0
        to_bullet[:3, 3:6] = to_bullet[3:6, :3] = frame
        to_bullet[3:6, 3:6] = -frame @ np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        turned: Array = to_bullet.T @ found @ to_bullet
        return turned

    def bias(self) -> Array:
        # from a real step, without ground: Bullet's inverse dynamics corrupts memory with a floating base
        zero = np.zeros(len(self._joints))
        base, h = self._base.copy(), self.physics.timestep
        state = State(self._position, self._velocity, base[:3], base[3:7], base[7:10], base[10:])
        bare = self.model.with_armature(zero)  # the law for armature would act on the step
        with closing(PybulletSimulation(bare, replace(self.physics, ground=None))) as free:
            free.reset(state)
            free.step(zero, zero, zero)
            acceleration = (free._speeds() - self._speeds()) / h
            after = free._base
        if self.model.floating:
            # what is stepped is the velocity of the centre of mass, v + omega x arm; the origin's differs by order h
            arm, swung = (rotation_from_quaternion(b[3:7]) @ self._com for b in (base, after))
            omega, alpha = base[10:], acceleration[3:6]
            acceleration[:3] += (np.cross(after[10:], swung) - np.cross(omega, arm)) / h
            acceleration[:3] -= np.cross(alpha, arm) + np.cross(omega, np.cross(omega, arm))
        bias: Array = -self.mass_matrix() @ acceleration
        return bias

    def _inverse(self, start: State, position: Array, velocity: Array, acceleration: Array) -> Array:
        body, client = self._body, self._client
        turn = rotation_from_quaternion(start.base_quaternion) @ self._principal
        gravity = (turn.T @ self.physics.gravity).tolist()  # in the base's axes, which Bullet takes for the world's
        self.reset(start)
        pybullet.setGravity(*gravity, physicsClientId=client)
        out = np.empty_like(position)
        with unprinted():  # on axes that are not of unit length to the last bit, which it mends
            for k in range(len(out)):
                q, v, a = position[k].tolist(), velocity[k].tolist(), acceleration[k].tolist()
                out[k] = pybullet.calculateInverseDynamics(body, q, v, a, physicsClientId=client)
        pybullet.setGravity(*self.physics.gravity, physicsClientId=client)
        return out

    def _speeds(self) -> Array:
        return np.concatenate([self._base[7:] if self.model.floating else [], self._velocity])

    def close(self) -> None:
        if pybullet.isConnected(self._client):
            pybullet.disconnect(self._client)


def _limited(lower: float, upper: float) -> bool:
    return bool(np.isfinite(lower) or np.isfinite(upper))


def _urdf(model: Model) -> str:
    """The model's URDF with its finite limits, which Bullet takes from the file only, and principal moments of inertia.

    Bullet finds the principal axes itself, but to eleven digits only.
    """
    tree = ElementTree.fromstring(write_urdf(model))
    for link, element in zip(model.links, tree.iter("inertial"), strict=True):
        moments, axes = np.linalg.eigh(link.inertia)
        axes[:, 2] *= np.linalg.det(axes)  # right-handed
        origin, inertia = element.find("origin"), element.find("inertia")
        assert origin is not None
        assert inertia is not None
        origin.set("rpy", " ".join(repr(angle) for angle in rpy_from_rotation(axes)))
        ixx, iyy, izz = map(repr, moments.tolist())
        inertia.attrib.update(ixx=ixx, iyy=iyy, izz=izz, ixy="0", ixz="0", iyz="0")
    for joint, element in zip(model.joints, tree.iter("joint"), strict=True):
        if _limited(joint.lower, joint.upper):
            element.set("type", "prismatic" if joint.prismatic else "revolute")
            for old in element.findall("limit"):
                element.remove(old)
            lower, upper = repr(max(joint.lower, -FREE)), repr(min(joint.upper, FREE))
            ElementTree.SubElement(element, "limit", lower=lower, upper=upper, effort="1e9", velocity="1e9")
    return ElementTree.tostring(tree, encoding="unicode")


def _open(model: Model, physics: Physics) -> tuple[int, int]:
    """A client with the robot, the ground and no hidden physics; the numbers of client and robot."""
    client = pybullet.connect(pybullet.DIRECT)
    pybullet.setPhysicsEngineParameter(enableFileCaching=0, physicsClientId=client)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "robot.urdf"
        path.write_text(_urdf(model), encoding="utf-8")
        body = pybullet.loadURDF(
            str(path),
            useFixedBase=not model.floating,
            flags=pybullet.URDF_USE_INERTIA_FROM_FILE | pybullet.URDF_MAINTAIN_LINK_ORDER,
            physicsClientId=client,
        )
    pybullet.setGravity(*physics.gravity, physicsClientId=client)
    pybullet.setPhysicsEngineParameter(
        fixedTimeStep=physics.timestep,
        numSubSteps=0,
        numSolverIterations=ITERATIONS if physics.solver_iterations is None else physics.solver_iterations,
        solverResidualThreshold=0.0,
        contactSlop=0.0,
        deterministicOverlappingPairs=1,
        enableConeFriction=1,
        restitutionVelocityThreshold=FREE,
        physicsClientId=client,
    )
    n = len(model.joints)
    if n:
        pybullet.setJointMotorControlArray(
            body, list(range(n)), pybullet.VELOCITY_CONTROL, forces=[0.0] * n, physicsClientId=client
        )
    for link in range(-1, n):
        change = {"bodyUniqueId": body, "linkIndex": link, "physicsClientId": client}
        pybullet.changeDynamics(**change, maxJointVelocity=FREE)
        # in a call of its own: together with the line above the damping is dropped
        pybullet.changeDynamics(**change, linearDamping=0.0, angularDamping=0.0, jointDamping=0.0)
        pybullet.changeDynamics(**change, lateralFriction=1.0, **SMOOTH)
    pybullet.changeDynamics(
        body, -1, activationState=pybullet.ACTIVATION_STATE_DISABLE_SLEEPING, physicsClientId=client
    )
    if physics.ground is not None:
        _lay(client, physics)
    return client, body


def _lay(client: int, physics: Physics) -> None:
    """The ground. Bullet multiplies the friction of a pair, and the robot has 1."""
    assert physics.ground is not None
    shape = pybullet.createCollisionShape(pybullet.GEOM_PLANE, planeNormal=[0, 0, 1], physicsClientId=client)
    plane = pybullet.createMultiBody(0.0, shape, physicsClientId=client)
    change = {"bodyUniqueId": plane, "linkIndex": -1, "physicsClientId": client}
    pybullet.changeDynamics(**change, lateralFriction=physics.ground.friction, **SMOOTH)
    if physics.ground.stiffness is not None:
        damping = physics.ground.damping or 0.0
        pybullet.changeDynamics(**change, contactStiffness=physics.ground.stiffness, contactDamping=damping)


def _settings(client: int, physics: Physics) -> dict[str, object]:
    found = pybullet.getPhysicsEngineParameters(physicsClientId=client)
    return {
        **found,
        "solver iterations": found["numSolverIterations"],
        "default motors, link damping, sleeping, restitution, self collision": "off",
        "maxJointVelocity": FREE,
        "inertia": "from file",
        "robot friction": 1.0,
        "ground friction": None if physics.ground is None else physics.ground.friction,
        "contactStiffness": None if physics.ground is None else physics.ground.stiffness,
        "contactDamping": None if physics.ground is None else physics.ground.damping,
    }


class PybulletEngine(Engine):
    """PyBullet. See `Engine`."""

    name = "pybullet"

    @cached_property
    def version(self) -> str:
        return version("pybullet")

    def capabilities(self) -> dict[str, Capability]:
        return {
            "armature": Capability("emulated", "law.joints and ballast; standing within 2e-5 rad of MuJoCo"),
            "forward_dynamics": Capability("native", "generalized coordinates, articulated bodies"),
            "joint_damping": Capability("emulated", "law.joints, exact; Bullet's own is explicit"),
            "joint_friction": Capability("emulated", "law.joints; exact, without creep"),
            "joint_limits": Capability("native", "rows of the contact problem"),
            "lone_body": Capability("native", "as with joints"),
            "mimic_joints": MIMIC_JOINTS,
            "rigid_ground": Capability("native", "friction cone, projected Gauss-Seidel"),
            "soft_ground": Capability("native", "contactStiffness and contactDamping of the ground"),
            "solver_iterations": Capability("native", "numSolverIterations, all of them carried out"),
        }

    def open(self, model: Model, physics: Physics) -> Simulation:
        return coupled(PybulletSimulation(model, physics))


ENGINE = PybulletEngine()
__all__ = ["ENGINE", "PybulletEngine", "PybulletSimulation"]
