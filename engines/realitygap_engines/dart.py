"""DART: generalized coordinates, articulated-body algorithm, contact as a cone complementarity problem.

How it solves: free acceleration first, then contact and limit impulses by nonsmooth Gauss-Seidel sweeps over exact
Coulomb cones (Jean, Moreau 1992), then positions from the new velocities.
Where it lies by default: its Dantzig solver turns the friction cone into a pyramid in world axes, so that a block that
slides at 45 degrees stops 30 % too early; resting bodies fall asleep and their contact forces read 0; a body without
inertia gets 1 kg; enforcing position limits enforces velocity limits too; a torque or state that is not a number is
replaced and a message printed; friction of a pair is the smaller of the two. Its implicit joint damping is not seen
by the contact solver (error of order h), it has no armature and its contacts no stiffness, so that all of these come
from `realitygap_engines.law.joints`; on soft ground its own contact solver has nothing to do.
"""

from dataclasses import replace
from functools import cached_property
from importlib.metadata import version
from math import cos, hypot, isfinite, sin, sqrt

import dartpy
import numpy as np

from realitygap_engines.engine import Capability, Engine, Physics, Simulation, State
from realitygap_engines.errors import Diverged
from realitygap_engines.law.joints import JointLaw
from realitygap_engines.law.mimic import MIMIC_JOINTS, coupled
from realitygap_engines.law.runaway import RUNAWAY, diverged
from realitygap_engines.model.robot import Array, Model, rotation_from_quaternion

STICKY = 1e6
"""Friction coefficient of the robot's spheres: the ground's is smaller, and DART takes the smaller of a pair."""
SWEEPS = 100
"""Sweeps of the contact solver, at most; about five are needed in a step of a standing humanoid."""
TOLERANCE = 1e-5
"""Violation of the contact law at which the sweeps end, in the solver's own relative measure."""


class DartSimulation(Simulation):
    """One `World` with one `Skeleton`. See `Simulation`."""

    def __init__(self, model: Model, physics: Physics) -> None:
        self.model = model
        self.physics = physics
        n = len(model.joints)
        soft = physics.ground is not None and physics.ground.stiffness is not None
        self._law = JointLaw(
            model, physics, native_armature=False, native_damping=False, native_ground=not soft, ballast=not soft
        )
        self._world, self._skeleton, self._root = _build(
            self._law.model, replace(physics, ground=None) if soft else physics
        )
        self._offset = o = 6 if model.floating else 0
        names = [self._skeleton.getDof(o + i).getName() for i in range(n)]
        order = [names.index(joint.name) for joint in model.joints]
        self._joints = slice(o, None) if order == list(range(n)) else np.array(order) + o
        self._forces = np.zeros(o + n)
        self._pushed = bool(o) and (soft or self._law.ballasted)
        self._position, self._velocity, self._base = np.zeros(n), np.zeros(n), np.zeros(13)
        solver = self._world.getConstraintSolver()
        self.settings = {
            "timestep": self._world.getTimeStep(),
            "gravity": self._world.getGravity().ravel().tolist(),
            "collision detector": self._world.getCollisionDetector().getType(),
            "solver": solver.getBoxedLcpSolver().getType(),
            "solver iterations, at most": solver.getBoxedLcpSolver().getOptions().maxSweeps,
            "solver tolerance": solver.getBoxedLcpSolver().getOptions().tolerance,
            "friction law": solver.getBoxedLcpSolver().getOptions().law.name,
            "solver where that fails": solver.getSecondaryBoxedLcpSolver().getType(),
            "split impulse": solver.isSplitImpulseEnabled(),
            "deactivation": self._world.getDeactivationOptions().mEnabled,
            "self collision": self._skeleton.getSelfCollisionCheck(),
            "robot friction": None if physics.ground is None else STICKY,
            "ground friction": None if physics.ground is None else physics.ground.friction,
            "restitution": 0.0,
            "limits enforced": [j.name for j in model.joints if np.isfinite(j.lower) or np.isfinite(j.upper)],
            "armature, damping, dry friction": "emulated by realitygap_engines.law.joints",
            "ballast": self._law.ballasted,
            "soft ground": "emulated by realitygap_engines.law.joints" if soft else None,
        }
        self.reset(State(np.zeros(n), np.zeros(n)))

    def reset(self, state: State) -> None:
        skeleton = self._skeleton
        self._world.reset()
        self._world.getConstraintSolver().clearLastCollisionResult()
        self._world.setCollisionDetector(dartpy.collision.DARTCollisionDetector())  # the last one remembers contacts
        position, velocity = np.zeros_like(self._forces), np.zeros_like(self._forces)
        position[self._joints], velocity[self._joints] = state.position, state.velocity
        pose = dartpy.math.Isometry3()
        pose.set_rotation(rotation_from_quaternion(state.base_quaternion))
        pose.set_translation(state.base_position)
        if self._offset:
            position[:6] = dartpy.dynamics.FreeJoint.convertToPositions(pose).ravel()
            velocity[:3], velocity[3:6] = state.base_angular, state.base_linear
        else:
            self._root.setTransformFromParentBodyNode(pose)
            self._base[:3], self._base[3:7] = state.base_position, state.base_quaternion
        skeleton.resetAccelerations()
        skeleton.clearConstraintImpulses()
        skeleton.clearExternalForces()
        skeleton.setPositions(position)
        skeleton.setVelocities(velocity)
        self._law.reset()
        self._steps = 0
        self._fetch()

    def step(self, effort: Array, damping: Array, friction: Array) -> None:
        self._steps += 1
        effort = self._law.effort(self._position, self._velocity, self._base, effort, damping, friction)
        if not isfinite(sum(effort.tolist())):
            raise self._diverged(effort, "effort is not finite")
        self._forces[self._joints] = effort
        if self._pushed:
            self._forces[:3], self._forces[3:6] = self._law.wrench[3:], self._law.wrench[:3]
        self._skeleton.setForces(self._forces)
        self._world.step(False)
        self._fetch()

    def _fetch(self) -> None:
        position, velocity = self._skeleton.getPositions(), self._skeleton.getVelocities()
        if not hypot(*velocity.tolist()) < RUNAWAY:
            # DART would replace what overflows by zeros and go on
            raise self._diverged(velocity[self._joints], "velocity runs away")
        self._position, self._velocity = position[self._joints], velocity[self._joints]
        if self._offset:
            base = self._base
            base[:3] = position[3:6]
            base[3:7] = _quaternion_from_rotation_vector(*position[:3].tolist())
            base[7:10] = velocity[3:6]
            base[10:] = velocity[:3]

    def _diverged(self, values: Array, what: str) -> Diverged:
        return diverged(self.model, self._steps * self.physics.timestep, values, what)

    def read(self, position: Array, velocity: Array, base: Array) -> None:
        position[:] = self._position
        velocity[:] = self._velocity
        if self._offset:
            base[:] = self._base

    def dry_friction(self) -> Array:
        return self._law.dry

    def mass_matrix(self) -> Array:
        order = self._world_order()
        ballast, _ = self._law.ballast(self._position, self._velocity, self._base)
        return np.asarray(self._skeleton.getMassMatrix())[np.ix_(order, order)] - ballast

    def bias(self) -> Array:
        _, ballast = self._law.ballast(self._position, self._velocity, self._base)
        return np.asarray(self._skeleton.getCoriolisAndGravityForces()).ravel()[self._world_order()] - ballast

    def _inverse(self, start: State, position: Array, velocity: Array, acceleration: Array) -> Array:
        skeleton, out = self._skeleton, np.empty_like(position)
        self.reset(start)
        row = np.empty((3, position.shape[1]))
        for k in range(len(position)):
            row[0, self._joints], row[1, self._joints], row[2, self._joints] = position[k], velocity[k], acceleration[k]
            skeleton.setPositions(row[0])
            skeleton.setVelocities(row[1])
            skeleton.setAccelerations(row[2])
            skeleton.computeInverseDynamics(False, False, False)
            out[k] = skeleton.getForces()[self._joints]
        return out

    def _world_order(self) -> "np.ndarray[tuple[int], np.dtype[np.int64]]":
        """DART's free joint counts rotation first, both parts in world axes already."""
        indices = np.arange(len(self._forces))
        return np.concatenate([[3, 4, 5, 0, 1, 2] if self._offset else [], indices[self._joints]]).astype(np.int64)


def _quaternion_from_rotation_vector(x: float, y: float, z: float) -> tuple[float, float, float, float]:
    """Unit quaternion w x y z (w >= 0) of a rotation vector; plain floats, because numpy is slow on three elements."""
    angle = sqrt(x * x + y * y + z * z)
    if angle < 1e-8:  # sin(a/2)/a to double precision
        return 1.0, 0.5 * x, 0.5 * y, 0.5 * z
    scale = sin(0.5 * angle) / angle
    w = cos(0.5 * angle)
    if w < 0:
        w, scale = -w, -scale
    return w, scale * x, scale * y, scale * z


def _build(
    model: Model, physics: Physics
) -> "tuple[dartpy.simulation.World, dartpy.dynamics.Skeleton, dartpy.dynamics.Joint]":
    world = dartpy.simulation.World()
    world.setTimeStep(physics.timestep)
    world.setGravity(physics.gravity)
    world.setCollisionDetector(dartpy.collision.DARTCollisionDetector())
    awake = dartpy.simulation.DeactivationOptions()
    awake.mEnabled = False
    world.setDeactivationOptions(awake)
    cones = dartpy.constraint.NsgsFrictionSolver()
    options = cones.getOptions()
    options.maxSweeps = SWEEPS if physics.solver_iterations is None else physics.solver_iterations
    options.tolerance = TOLERANCE
    cones.setOptions(options)
    solver = world.getConstraintSolver()
    pivoting = solver.getBoxedLcpSolver()
    solver.setBoxedLcpSolver(cones)
    solver.setSecondaryBoxedLcpSolver(pivoting)
    skeleton = dartpy.dynamics.Skeleton(model.name)
    skeleton.disableSelfCollisionCheck()
    bodies: list[dartpy.dynamics.BodyNode] = []
    root = None
    for i, link in enumerate(model.links):
        if i:
            body = _add_body(skeleton, bodies[model.joints[i - 1].parent], model, i)
        elif model.floating:
            root, body = skeleton.createFreeJointAndBodyNodePair()
        else:
            root, body = skeleton.createWeldJointAndBodyNodePair()
        body.setName(link.name)
        body.setInertia(dartpy.dynamics.Inertia(link.mass, link.com, link.inertia))
        for sphere in link.spheres if physics.ground is not None and (i or model.floating) else ():
            shape = body.createShapeNode(dartpy.dynamics.SphereShape(sphere.radius))
            shape.setRelativeTranslation(sphere.center)
            shape.createCollisionAspect()
            shape.createDynamicsAspect().setFrictionCoeff(STICKY)
        bodies.append(body)
    world.addSkeleton(skeleton)
    if physics.ground is not None:
        ground = dartpy.dynamics.Skeleton("ground")
        _, body = ground.createWeldJointAndBodyNodePair()
        shape = body.createShapeNode(dartpy.dynamics.PlaneShape([0.0, 0.0, 1.0], 0.0))
        shape.createCollisionAspect()
        shape.createDynamicsAspect().setFrictionCoeff(physics.ground.friction)
        ground.setMobile(False)
        world.addSkeleton(ground)
    return world, skeleton, root


def _add_body(
    skeleton: "dartpy.dynamics.Skeleton", parent: "dartpy.dynamics.BodyNode", model: Model, i: int
) -> "dartpy.dynamics.BodyNode":
    joint = model.joints[i - 1]
    if joint.prismatic:
        made, body = skeleton.createPrismaticJointAndBodyNodePair(parent)
    else:
        made, body = skeleton.createRevoluteJointAndBodyNodePair(parent)
    made.setName(joint.name)
    made.setAxis(joint.axis)
    origin = dartpy.math.Isometry3()
    origin.set_rotation(joint.origin[:3, :3])
    origin.set_translation(joint.origin[:3, 3])
    made.setTransformFromParentBodyNode(origin)
    if np.isfinite(joint.lower) or np.isfinite(joint.upper):
        made.setPositionLowerLimit(0, joint.lower)
        made.setPositionUpperLimit(0, joint.upper)
        made.setLimitEnforcement(True)
    return body


class DartEngine(Engine):
    """DART. See `Engine`."""

    name = "dart"

    @cached_property
    def version(self) -> str:
        return version("dartpy")

    def capabilities(self) -> dict[str, Capability]:
        return {
            "armature": Capability("emulated", "law.joints; DART has none"),
            "forward_dynamics": Capability("native", "generalized coordinates, articulated bodies"),
            "joint_damping": Capability("emulated", "law.joints; DART's own is not seen by its contact solver"),
            "joint_friction": Capability("emulated", "law.joints"),
            "joint_limits": Capability("native", "rows of the contact problem, without velocity limits"),
            "lone_body": Capability("native", "as with joints"),
            "mimic_joints": MIMIC_JOINTS,
            "rigid_ground": Capability("native", "complementarity, exact Coulomb cones"),
            "soft_ground": Capability("emulated", "law.joints: implicit spring and damper per point, Coulomb's law"),
            "solver_iterations": Capability("native", "sweeps over the contacts, at most"),
        }

    def open(self, model: Model, physics: Physics) -> Simulation:
        return coupled(DartSimulation(model, physics))


ENGINE = DartEngine()
__all__ = ["ENGINE", "DartEngine", "DartSimulation"]
