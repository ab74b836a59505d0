"""ODE: maximal coordinates, joints and contacts as velocity constraints; the engine of Gazebo classic and the thesis.

How it solves: every link is a free body; joints, motors and contacts are rows of one linear complementarity problem
for the end-of-step velocities. `solver_iterations` sweeps of `dWorldQuickStep` (projected Gauss-Seidel, over-relaxed)
leave an error in joints and contacts that shrinks with their number; without a number `dWorldStep` solves the
problem by pivoting (Dantzig). Positions follow from the new velocities, and errors of position are corrected by the
share ERP per step. Rotor inertia A and damping D of a joint are a motor that drives towards A v/(A + h D) with the
compliance h/(A + h D): the law of `engine`, in one problem with the contacts. Dry friction is a motor of
limited torque that drives towards 0. (`law.joints` in place of the motors was tried: equal where the problem is
solved to the end and closer at 200 sweeps, but a humanoid on its feet explodes at 100 and fewer; so it does when
the motors start from the torques of the step before.)
Where it lies by default: friction is a pyramid in world axes with a fixed bound, bodies at rest fall asleep,
gyroscopic torque and rotation are linearised, the order of the rows is drawn from one generator for all worlds, and
angles wrap. All of that is switched off or undone here. Stops beyond half a turn are dropped.
What it cannot do: a joint is a constraint that is never quite met, and centripetal and Coriolis terms come in one
step late, so that one step from a moving state is no forward dynamics and a chain drifts away by an error of order h.
"""

from math import hypot, inf, isfinite

import numpy as np

from realitygap_engines.engine import Capability, Engine, Physics, Simulation, State
from realitygap_engines.errors import Diverged
from realitygap_engines.law.dynamics import Dynamics
from realitygap_engines.law.mimic import MIMIC_JOINTS, coupled
from realitygap_engines.law.runaway import RUNAWAY, diverged
from realitygap_engines.model.robot import Array, Model
from realitygap_engines.ode.contact import ContactPoints
from realitygap_engines.ode.library import CFM, FMAX, VEL, version_of
from realitygap_engines.ode.robot import OdeJoint, OdeRobot, ode

ERP = 0.2
"""Share of a position error that is corrected per step: ODE's default, and Gazebo's."""
COMPLIANCE = 1e-10
"""CFM of all rows that have none of their own: ODE's default with double precision."""
OVER_RELAXATION = 1.3
"""Of quickStep: ODE's default, and Gazebo's."""


class OdeSimulation(Simulation):
    """One world with one robot. See `Simulation`."""

    def __init__(self, model: Model, physics: Physics) -> None:
        self.model = model
        self.physics = physics
        self._h, self._floating = physics.timestep, model.floating
        n = len(model.joints)
        self._world = world = ode.dWorldCreate()
        ode.dWorldSetGravity(world, *physics.gravity)
        ode.dWorldSetERP(world, ERP)
        ode.dWorldSetCFM(world, COMPLIANCE)
        ode.dWorldSetAutoDisableFlag(world, 0)
        ode.dWorldSetContactMaxCorrectingVel(world, inf)
        ode.dWorldSetQuickStepW(world, OVER_RELAXATION)
        if physics.solver_iterations is not None:
            ode.dWorldSetQuickStepNumIterations(world, physics.solver_iterations)
        self._advance = ode.dWorldStep if physics.solver_iterations is None else ode.dWorldQuickStep
        self._robot = OdeRobot(world, model)
        self._contacts = None if physics.ground is None else ContactPoints(world, model, self._robot.links, physics)
        self._position, self._velocity, self._base = np.zeros(n), np.zeros(n), np.zeros(13)
        self._armature = model.armature
        self._damping, self._friction = [-1.0] * n, [-1.0] * n  # none of them is set yet
        self._rotors: list[tuple[OdeJoint, float, int]] = []
        self.settings = {
            "step function": "dWorldStep" if physics.solver_iterations is None else "dWorldQuickStep",
            "quickStep iterations": None
            if physics.solver_iterations is None
            else ode.dWorldGetQuickStepNumIterations(world),
            "quickStep over-relaxation": ode.dWorldGetQuickStepW(world),
            "timestep": physics.timestep,
            "gravity": list(physics.gravity),
            "ERP": ode.dWorldGetERP(world),
            "CFM": ode.dWorldGetCFM(world),
            "contact maximum correcting velocity": ode.dWorldGetContactMaxCorrectingVel(world),
            "contact surface layer": ode.dWorldGetContactSurfaceLayer(world),
            "contact friction": None if self._contacts is None else self._contacts.friction,
            "contact ERP": None if self._contacts is None else self._contacts.erp,
            "contact CFM": None if self._contacts is None else self._contacts.cfm,
            "friction law": "against the slip; at rest a pyramid; bounded by the load: "
            + ("of the steps before" if physics.solver_iterations is None else "of the sweep before"),
            "auto-disable": bool(ode.dWorldGetAutoDisableFlag(world)),
            "gyroscopic mode, finite rotation mode": "on",
            "limits enforced": self._robot.limited,
            "armature, damping, dry friction": "motors",
        }
        self.reset(State(np.zeros(n), np.zeros(n)))

    def reset(self, state: State) -> None:
        self._robot.reset(state)
        self._position[:] = state.position
        self._base[:3], self._base[3:7] = state.base_position, state.base_quaternion
        self._seed = 0
        self._steps = 0
        if self._contacts is not None:
            self._contacts.reset()
        for joint in self._robot.joints:
            joint.load.force1[:] = joint.load.torque1[:] = [0.0] * 4
        self._fetch()

    def step(self, effort: Array, damping: Array, friction: Array) -> None:
        self._steps += 1
        efforts = effort.tolist()
        if not isfinite(sum(efforts)):  # ODE would end the process
            raise self._diverged(effort, "effort is not finite")
        damped, braked = damping.tolist(), friction.tolist()
        if damped != self._damping:
            self._set_rotors(damped)
        if braked != self._friction:
            self._set_brakes(braked)
        for joint, given in zip(self._robot.joints, efforts, strict=True):
            joint.push(joint.joint, given)
        for joint, share, speed in self._rotors:
            joint.set_motor(joint.rotor, VEL, share * self._velocity.item(speed))
        if self._contacts is not None:
            self._contacts.make()
        ode.dRandSetSeed(self._seed)  # the generator is one for all worlds
        self._advance(self._world, self._h)
        self._seed = ode.dRandGetSeed()
        if self._contacts is not None:
            self._contacts.clear()
        self._fetch()

    def _set_rotors(self, damping: list[float]) -> None:
        h = self._h
        self._rotors = []
        for i, (joint, a, d, before) in enumerate(
            zip(self._robot.joints, self._armature.tolist(), damping, self._damping, strict=True)
        ):
            mass = a + h * d
            if d != before:
                joint.set_motor(joint.rotor, FMAX, inf if mass > 0 else 0.0)
                joint.set_motor(joint.rotor, VEL, 0.0)
                if mass > 0:
                    joint.set_motor(joint.rotor, CFM, h / mass)
            if a > 0:
                self._rotors.append((joint, a / mass, i))
        self._damping = damping

    def _set_brakes(self, friction: list[float]) -> None:
        for joint, bound, before in zip(self._robot.joints, friction, self._friction, strict=True):
            if bound != before:
                joint.set_motor(joint.brake, FMAX, bound)
        self._friction = friction

    def _fetch(self) -> None:
        fastest = self._robot.read_joints(self._position, self._velocity)
        if self._floating:
            self._robot.read_base(self._base)
            fastest = hypot(fastest, *self._base[7:].tolist())
        if not fastest < RUNAWAY:
            raise self._diverged(self._velocity, "velocity runs away")

    def _diverged(self, values: Array, what: str) -> Diverged:
        return diverged(self.model, self._steps * self.physics.timestep, values, what)

    def read(self, position: Array, velocity: Array, base: Array) -> None:
        position[:] = self._position
        velocity[:] = self._velocity
        if self._floating:
            base[:] = self._base

    def dry_friction(self) -> Array:
        return self._robot.braking(self._friction)

    def mass_matrix(self) -> Array:
        inertia = self._robot.inertia_and_bias(self._speed(), np.zeros(3))[0]
        joints = np.arange(len(inertia) - len(self._armature), len(inertia))
        inertia[joints, joints] += self._armature
        return inertia

    def bias(self) -> Array:
        return self._robot.inertia_and_bias(self._speed(), np.array(self.physics.gravity))[1]

    def _inverse(self, start: State, position: Array, velocity: Array, acceleration: Array) -> Array:
        # ODE has no inverse dynamics: what it holds of the machine is moved by the compiled Newton and Euler
        self.reset(State(np.zeros(position.shape[1]), np.zeros(position.shape[1])))
        held = Dynamics(self._robot.held())
        base = np.concatenate([start.base_position, start.base_quaternion, np.zeros(6)])
        return held.inverse(position, velocity, acceleration, base, np.array(self.physics.gravity))

    def _speed(self) -> Array:
        return np.concatenate([self._base[7:] if self.model.floating else [], self._velocity])

    def close(self) -> None:
        if self._world is not None:
            if self._contacts is not None:
                self._contacts.close()
            ode.dWorldDestroy(self._world)
            self._world = None


class OdeEngine(Engine):
    """ODE. See `Engine`."""

    name = "ode"

    @property
    def version(self) -> str:
        return version_of(ode)

    def capabilities(self) -> dict[str, Capability]:
        return {
            "armature": Capability("native", "a motor with the compliance h/armature, in one problem with contacts"),
            "forward_dynamics": Capability(
                "no", "maximal coordinates, Coriolis terms a step late: an error of order h"
            ),
            "joint_damping": Capability("native", "the same motor: implicit"),
            "joint_friction": Capability("native", "a motor of limited torque"),
            "joint_limits": Capability("native", "stops of the joint; of a hinge within half a turn only"),
            "lone_body": Capability("no", "Coriolis terms a step late: an error of order h"),
            "mimic_joints": MIMIC_JOINTS,
            "rigid_ground": Capability(
                "native", "cone where it slides; a point at rest has a pyramid and holds up to 1.4 times askew"
            ),
            "soft_ground": Capability("native", "ERP and CFM per point: implicit spring and damper"),
            "solver_iterations": Capability("native", "sweeps of quickStep; without a number, pivoting (dWorldStep)"),
        }

    def open(self, model: Model, physics: Physics) -> Simulation:
        return coupled(OdeSimulation(model, physics))


ENGINE = OdeEngine()
__all__ = ["ENGINE", "OdeEngine", "OdeSimulation"]
