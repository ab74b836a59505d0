"""Drake: generalized coordinates, discrete updates whose contact is a convex problem solved to convergence.

How it solves: contact, joint limits and joint damping are parts of one implicit velocity problem in the metric
M + h·D (Castro et al. 2022); positions follow from the new velocities. The ground is its `sap` approximation, whose
contact is exactly the linear spring and damper that the scenario asks for, `max(0, k·depth + b·depth rate)`; rigid
ground has a stiffness far above any weight, and a damper. (`lagged` and `similar` bound friction by what the stiff
spring would press with at the step's start: at an impact the one sticks, and the other has half of Coulomb's friction.)
Where it lies by default: the default contact stiffness sinks a robot by a visible fraction of a millimetre, `sap`
softens contacts beyond a threshold that grows with the step, output ports are copied at every step, friction of a
pair is the harmonic mean, and a URDF's friction, effort limits and mimic joints need care: the plant is built here,
not parsed. It has no dry joint friction, which comes from `law.joints`, and it iterates until converged, so that
there is no iteration count.
"""
# mypy: allow-untyped-defs
# (the compiled functions take arrays and numbers only; their callers are typed)

import gc
from functools import cached_property
from importlib.metadata import version
from itertools import count

import numpy as np
from pydrake.geometry import (
    AddContactMaterial,
    CollisionFilterDeclaration,
    GeometrySet,
    HalfSpace,
    ProximityProperties,
    SceneGraph,
)
from pydrake.geometry import Sphere as Ball
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import AddMultibodyPlant, CoulombFriction, MultibodyPlant, MultibodyPlantConfig
from pydrake.multibody.tree import (
    FixedOffsetFrame,
    MultibodyForces,
    PrismaticJoint,
    QuaternionFloatingJoint,
    RevoluteJoint,
    RigidBody,
    RotationalInertia,
    SpatialInertia,
)
from pydrake.systems.framework import Diagram, DiagramBuilder

from realitygap_engines.engine import Capability, Engine, Physics, Simulation, State
from realitygap_engines.errors import Diverged
from realitygap_engines.law.compiled import compiled
from realitygap_engines.law.joints import JointLaw
from realitygap_engines.law.mimic import MIMIC_JOINTS, coupled
from realitygap_engines.model.quiet import quiet
from realitygap_engines.model.robot import Array, Model, rotation_from_quaternion

RIGID = 1e8
"""Stiffness [N/m] of a rigid contact point: 10 kg sink by a micrometre."""
RELAXATION = 5.0
"""Steps in which a rigid point that got below the surface comes up again. Without, it comes up within one step, at the
speed at which it fell: it bounces."""
KEPT = 16
"""Closed simulations after which they are freed: pydrake ties plant and diagram into a ring that only a full collection
finds, and Python, which does not see the half megabyte that they weigh, lets hundreds of them wait for one."""
CLOSED = count(1)


class DrakeSimulation(Simulation):
    """One diagram with one `MultibodyPlant` and its context. See `Simulation`."""

    def __init__(self, model: Model, physics: Physics) -> None:
        self.model = model
        self.physics = physics
        n = len(model.joints)
        with quiet("drake"):  # of its warning that half spaces do not touch deformable bodies: there are none
            self._plant, self._diagram, self._pedestal = _build(model, physics)
            self._context = self._diagram.CreateDefaultContext()
        plant = self._plant
        self._plant_context = plant.GetMyMutableContextFromRoot(self._context)
        self._next = self._diagram.AllocateDiscreteVariables()
        self._joints = [plant.GetJointByName(joint.name) for joint in model.joints]
        speeds = [joint.velocity_start() for joint in self._joints]
        base = [3, 4, 5, 0, 1, 2] if model.floating else []  # Drake counts rotation first
        self._world_order = np.array([*base, *speeds], dtype=np.int64)
        self._state = np.zeros(plant.num_multibody_states())
        o = plant.num_positions()
        self._q = np.array([joint.position_start() for joint in self._joints], dtype=np.int64)
        self._v = np.array([o + start for start in speeds], dtype=np.int64)
        free = [4, 5, 6, 0, 1, 2, 3, o + 3, o + 4, o + 5, o, o + 1, o + 2] if model.floating else []
        self._order = np.concatenate([self._q, self._v, np.array(free, dtype=np.int64)])
        inputs = [plant.GetJointActuatorByName(joint.name).input_start() for joint in model.joints]
        self._inputs = _run(inputs)
        self._actuation = plant.get_actuation_input_port().FixValue(self._plant_context, np.zeros(n)) if n else None
        self._law = JointLaw(model, physics, native_armature=True, native_damping=True)
        self._damping = np.zeros(n)
        row = np.zeros(2 * n + 13)
        self._position, self._velocity, self._base = row[:n], row[n : 2 * n], row[2 * n :]
        self._fetched = row[: len(self._order)]  # what is in Drake's state, in our order; a fixed base is not
        self._turn = 2 * n + 3 if model.floating else len(row)
        self.settings = {
            "time_step": plant.time_step(),
            "gravity": plant.gravity_field().gravity_vector().tolist(),
            "contact_model": plant.get_contact_model().name,
            "discrete_contact_approximation": plant.get_discrete_contact_approximation().name,
            "discrete_contact_solver": plant.get_discrete_contact_solver().name,
            "sap_near_rigid_threshold": plant.get_sap_near_rigid_threshold(),
            "use_sampled_output_ports": plant.has_sampled_output_ports(),
            "solver iterations": "not applicable: iterates until converged",
            **_material(physics),
            "rotor inertia": model.armature.tolist(),
            "effort limits": "none",
            "dry friction": "emulated by realitygap_engines.law.joints",
        }
        self.reset(State(np.zeros(n), np.zeros(n)))

    def reset(self, state: State) -> None:
        plant, context = self._plant, self._plant_context
        x = self._state
        x[self._q], x[self._v] = state.position, state.velocity
        if self._pedestal is None:
            nq = plant.num_positions()
            x[:4], x[4:7] = state.base_quaternion, state.base_position
            x[nq : nq + 3], x[nq + 3 : nq + 6] = state.base_angular, state.base_linear
        else:
            rotation = RotationMatrix(rotation_from_quaternion(state.base_quaternion))
            self._pedestal.SetPoseInParentFrame(context, RigidTransform(rotation, state.base_position))
            self._base[:3], self._base[3:7] = state.base_position, state.base_quaternion
        plant.SetPositionsAndVelocities(context, x)
        self._set_damping(np.zeros_like(self._damping))
        self._law.reset()
        self._steps = 0
        self._fetch()

    def step(self, effort: Array, damping: Array, friction: Array) -> None:
        self._steps += 1
        if self._actuation is not None:
            if damping.tobytes() != self._damped:
                self._set_damping(damping)
            effort = self._law.effort(self._position, self._velocity, self._base, effort, damping, friction)
            self._actuation.GetMutableData().get_mutable_value().get_mutable_value()[self._inputs] = effort
        try:  # the update that a Simulator would call, without its clock
            self._diagram.CalcForcedDiscreteVariableUpdate(self._context, self._next)
        except (RuntimeError, SystemExit) as error:  # a failed condition in Drake arrives as SystemExit
            raise self._diverged(effort, str(error).splitlines()[0]) from None
        self._context.SetDiscreteState(self._next)
        self._fetch()

    def _set_damping(self, damping: Array) -> None:
        for i in np.flatnonzero(damping != self._damping):
            self._joints[i].SetDampingVector(self._plant_context, damping[i : i + 1])
        self._damping[:] = damping
        self._damped = damping.tobytes()

    def _fetch(self) -> None:
        _in_order(self._plant.GetPositionsAndVelocities(self._plant_context), self._order, self._turn, self._fetched)

    def _diverged(self, effort: Array, what: str) -> Diverged:
        wrong = np.flatnonzero(~np.isfinite(effort + self._position + self._velocity))
        joint = self.model.joints[wrong[0]].name if len(wrong) else "base"
        return Diverged(self._steps * self.physics.timestep, joint, what)

    def read(self, position: Array, velocity: Array, base: Array) -> None:
        position[:] = self._position
        velocity[:] = self._velocity
        if self.model.floating:
            base[:] = self._base

    def dry_friction(self) -> Array:
        return self._law.dry

    def mass_matrix(self) -> Array:
        order = self._world_order
        return np.asarray(self._plant.CalcMassMatrix(self._plant_context))[np.ix_(order, order)]

    def bias(self) -> Array:
        plant, context = self._plant, self._plant_context
        bias = plant.CalcBiasTerm(context) - plant.CalcGravityGeneralizedForces(context)
        return np.asarray(bias)[self._world_order]

    def close(self) -> None:
        if next(CLOSED) % KEPT == 0:
            gc.collect()

    def _inverse(self, start: State, position: Array, velocity: Array, acceleration: Array) -> Array:
        plant, context = self._plant, self._plant_context
        self.reset(start)
        order, forces = self._world_order, MultibodyForces(plant)
        state, rate, out = self._state, np.zeros(plant.num_velocities()), np.empty_like(position)
        for k in range(len(position)):
            state[self._q], state[self._v], rate[order] = position[k], velocity[k], acceleration[k]
            plant.SetPositionsAndVelocities(context, state)
            plant.CalcForceElementsContribution(context, forces)  # gravity
            out[k] = plant.CalcInverseDynamics(context, rate, forces)[order]
        return out


@compiled
def _in_order(state, order, turn, out):
    """Take the state over; the norm of the quaternion, from the element `turn` on, drifts, and Drake does not mind."""
    for i in range(len(order)):
        out[i] = state[order[i]]
    if turn < len(out):
        w, x, y, z = out[turn], out[turn + 1], out[turn + 2], out[turn + 3]
        norm = np.sqrt(w * w + x * x + y * y + z * z)
        for k in range(turn, turn + 4):
            out[k] /= norm


def _run(indices: list[int]) -> slice | Array:
    """The indices as a slice where they are consecutive, which is faster."""
    if indices == list(range(indices[0] if indices else 0, (indices[0] if indices else 0) + len(indices))):
        return slice(indices[0], indices[0] + len(indices)) if indices else slice(0, 0)
    return np.array(indices)


def _material(physics: Physics) -> dict[str, float]:
    """Contact properties of every geometry, such that the combination of two equal ones is the ground asked for.

    Stiffnesses combine like springs in series, relaxation times (damping/stiffness) add, and the friction of equals is
    their own.
    """
    ground = physics.ground
    if ground is None:
        return {}
    if ground.stiffness is None:
        return {
            "point_contact_stiffness": 2 * RIGID,
            "relaxation_time": RELAXATION * physics.timestep / 2,
            "friction": ground.friction,
        }
    return {
        "point_contact_stiffness": 2 * ground.stiffness,
        "relaxation_time": (ground.damping or 0.0) / ground.stiffness / 2,
        "friction": ground.friction,
    }


def _build(model: Model, physics: Physics) -> tuple[MultibodyPlant, Diagram, FixedOffsetFrame | None]:
    """The plant, the diagram around it, and the frame in the world that carries a fixed base (None: floating)."""
    ground = physics.ground
    builder = DiagramBuilder()
    config = MultibodyPlantConfig(
        time_step=physics.timestep,
        contact_model="point",
        discrete_contact_approximation="sap",
        sap_near_rigid_threshold=0.0,
        use_sampled_output_ports=False,
    )
    plant, scene = AddMultibodyPlant(config, builder)
    plant.mutable_gravity_field().set_gravity_vector(physics.gravity)
    robot = plant.AddModelInstance("robot")
    bodies: list[RigidBody] = []
    for link in model.links:
        i = link.inertia
        inertia = RotationalInertia(i[0, 0], i[1, 1], i[2, 2], i[0, 1], i[0, 2], i[1, 2])
        inertial = SpatialInertia.MakeFromCentralInertia(link.mass, link.com, inertia)
        bodies.append(plant.AddRigidBody(link.name, robot, inertial))
    pedestal = None
    if model.floating:
        plant.AddJoint(QuaternionFloatingJoint("floating base", plant.world_frame(), bodies[0].body_frame()))
    else:
        pedestal = plant.AddFrame(FixedOffsetFrame("pedestal", plant.world_frame(), RigidTransform()))
        plant.WeldFrames(pedestal, bodies[0].body_frame())
    for joint, body in zip(model.joints, bodies[1:], strict=True):
        pose = RigidTransform(RotationMatrix(joint.origin[:3, :3]), joint.origin[:3, 3])
        frame = plant.AddFrame(FixedOffsetFrame(f"{joint.name} on parent", bodies[joint.parent].body_frame(), pose))
        kind = PrismaticJoint if joint.prismatic else RevoluteJoint
        made = plant.AddJoint(kind(joint.name, frame, body.body_frame(), joint.axis, joint.lower, joint.upper, 0.0))
        motor = plant.AddJointActuator(joint.name, made)
        motor.set_default_gear_ratio(1.0)
        motor.set_default_rotor_inertia(joint.armature)
    if ground is not None:
        _add_contact(model, physics, plant, scene, bodies)
    plant.Finalize()
    return plant, builder.Build(), pedestal


def _add_contact(
    model: Model, physics: Physics, plant: MultibodyPlant, scene: SceneGraph, bodies: list[RigidBody]
) -> None:
    values = _material(physics)
    material = ProximityProperties()
    friction = CoulombFriction(values["friction"], values["friction"])
    AddContactMaterial(material, point_stiffness=values["point_contact_stiffness"], friction=friction)
    material.AddProperty("material", "relaxation_time", values["relaxation_time"])
    plant.RegisterCollisionGeometry(plant.world_body(), RigidTransform(), HalfSpace(), "ground", material)
    spheres = []
    for i, (link, body) in enumerate(zip(model.links, bodies, strict=True)):
        for k, sphere in enumerate(link.spheres if i or model.floating else ()):
            spheres.append(
                plant.RegisterCollisionGeometry(
                    body, RigidTransform(sphere.center), Ball(sphere.radius), f"{link.name} {k}", material
                )
            )
    apart = CollisionFilterDeclaration().ExcludeWithin(GeometrySet(spheres))  # the robot does not touch itself
    scene.collision_filter_manager().Apply(apart)


class DrakeEngine(Engine):
    """Drake. See `Engine`."""

    name = "drake"

    @cached_property
    def version(self) -> str:
        return version("drake")

    def capabilities(self) -> dict[str, Capability]:
        return {
            "armature": Capability("native", "rotor inertia of the joint's actuator"),
            "forward_dynamics": Capability("native", "generalized coordinates"),
            "joint_damping": Capability("native", "implicit, in the metric of the contact problem"),
            "joint_friction": Capability("emulated", "law.joints"),
            "joint_limits": Capability("native", "constraints of the contact problem"),
            "lone_body": Capability("native", "as with joints"),
            "mimic_joints": MIMIC_JOINTS,
            "rigid_ground": Capability("native", f"sap with {RIGID:g} N/m per point, damped over {RELAXATION:g} steps"),
            "soft_ground": Capability("native", "sap: linear spring and damper per point, implicit"),
            "solver_iterations": Capability("no", "iterates until converged"),
        }

    def open(self, model: Model, physics: Physics) -> Simulation:
        return coupled(DrakeSimulation(model, physics))


ENGINE = DrakeEngine()
__all__ = ["ENGINE", "DrakeEngine", "DrakeSimulation"]
