"""What engines do silently, done again on purpose: the audit must fail and name the property that broke.

Every case runs the real engine with one setting wrong.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest
import realitygap_engines as engines
from realitygap.audit import Certificate
from realitygap.audit.audit import groups
from realitygap_engines import Capability, Engine, Physics, Simulation
from realitygap_engines.law.joints import JointLaw
from realitygap_engines.model.robot import Array, Model

Spoil = Callable[[Any], object]


class Spoiled(Engine):
    """An engine whose simulations are spoiled as soon as they are open."""

    def __init__(self, name: str, spoil: Spoil, model: Callable[[Model], Model]) -> None:
        self._real, self._spoil, self._model = engines.load(name), spoil, model
        self.name = name

    @property
    def version(self) -> str:
        return self._real.version

    def capabilities(self) -> dict[str, Capability]:
        return self._real.capabilities()

    def open(self, model: Model, physics: Physics) -> Simulation:
        simulation = self._real.open(self._model(model), physics)
        self._spoil(simulation)
        return simulation


@dataclass(frozen=True)
class Pitfall:
    """One pitfall: the engine, what is done to an open simulation or to the model, and the property that must fail."""

    what: str
    engine: str
    fails: str
    spoil: Spoil = lambda _: None
    model: Callable[[Model], Model] = lambda m: m


def fails(engine: Spoiled, name: str) -> None:
    """The audit's check of that name fails, and its certificate says so."""
    check = next(check for group in groups().values() for check in group if check.property == name)
    certificate = Certificate((check.row(engine),))
    assert not certificate.passed
    assert f"{engine.name}: {name}: failed" in certificate.text()


# --- PyBullet


def bullet(**change: Any) -> Spoil:
    """`changeDynamics` of every link."""
    import pybullet

    def spoil(s: Any) -> None:
        for link in range(-1, len(s.model.joints)):
            pybullet.changeDynamics(s._body, link, **change, physicsClientId=s._client)

    return spoil


def default_motor(s: Any) -> None:
    import pybullet

    joints = list(range(len(s.model.joints)))
    if joints:
        pybullet.setJointMotorControlArray(
            s._body, joints, pybullet.VELOCITY_CONTROL, forces=[1e-3] * len(joints), physicsClientId=s._client
        )


def bullet_kilogram(s: Any) -> None:
    import pybullet

    if s.model.joints:
        pybullet.changeDynamics(s._body, 0, mass=1.0, localInertiaDiagonal=[1, 1, 1], physicsClientId=s._client)


def frame_in_com(s: Any) -> None:
    s._com, s._principal, s._from_principal = (0.0, 0.0, 0.0), np.eye(3), (1.0, 0.0, 0.0, 0.0)


def friction_pyramid(s: Any) -> None:
    import pybullet

    pybullet.setPhysicsEngineParameter(enableConeFriction=0, physicsClientId=s._client)


def asleep(s: Any) -> None:
    import pybullet

    for link in range(-1, len(s.model.joints)):
        pybullet.changeDynamics(
            s._body, link, activationState=pybullet.ACTIVATION_STATE_ENABLE_SLEEPING, physicsClientId=s._client
        )


def law(**native: bool) -> Spoil:
    """The joint law outside the engine takes something for native that is not."""

    def spoil(s: Any) -> None:
        s._law = JointLaw(s.model, s.physics, **{"native_armature": False, "native_damping": False, **native})

    return spoil


FREE_SPIN = "free spin"
STOPPING = "block: stopping distance"
PYBULLET = (
    Pitfall("default velocity motor left on", "pybullet", FREE_SPIN, default_motor),
    Pitfall("link damping left on", "pybullet", "tree: one real step", bullet(linearDamping=0.04, angularDamping=0.04)),
    Pitfall("joint damping left on", "pybullet", FREE_SPIN, bullet(jointDamping=0.1)),
    Pitfall("speed limit left", "pybullet", FREE_SPIN, bullet(maxJointVelocity=100.0)),
    Pitfall("sleeping on", "pybullet", "no sleep: slow motion", asleep),
    Pitfall("pair friction taken as the product", "pybullet", STOPPING, bullet(lateralFriction=0.5)),
    Pitfall("friction pyramid", "pybullet", "block: stopping distance askew", friction_pyramid),
    Pitfall("base state in the centre of mass", "pybullet", "tree: one real step", frame_in_com),
    Pitfall("a link of 1 kg", "pybullet", "tree: total mass", bullet_kilogram),
    Pitfall("damping dropped", "pybullet", "joint damping: exponential decay", law(native_damping=True)),
    Pitfall("armature dropped", "pybullet", "armature: acceleration", law(native_armature=True)),
)

# --- MuJoCo


def mujoco_array(name: str, value: Any) -> Spoil:
    """An array of `mjModel` set to one value."""

    def spoil(s: Any) -> None:
        getattr(s._m, name)[:] = value

    return spoil


def mujoco_option(name: str, value: Any) -> Spoil:
    return lambda s: setattr(s._m.opt, name, value)


def lifted_inertias(s: Any) -> None:
    import mujoco

    s._m.body_inertia[1:] = np.maximum(s._m.body_inertia[1:], 1e-3)
    mujoco.mj_setConst(s._m, s._d)


def no_armature(s: Any) -> None:
    import mujoco

    s._m.dof_armature[:] = 0.0
    mujoco.mj_setConst(s._m, s._d)


def default_friction_softness(s: Any) -> None:
    s._m.dof_solref[:], s._m.dof_solimp[:] = (0.02, 1.0), (0.9, 0.95, 0.001, 0.5, 2.0)


def default_contact(s: Any) -> None:
    s._m.geom_solref[:], s._m.geom_solimp[:] = (0.02, 1.0), (0.9, 0.95, 0.001, 0.5, 2.0)


MUJOCO = (
    Pitfall("autoreset on", "mujoco", "a blow-up is seen", mujoco_option("disableflags", 0)),
    Pitfall("position limits left", "mujoco", "arm: one real step", mujoco_array("jnt_range", (-0.1, 0.1))),
    Pitfall("friction is the larger of the pair", "mujoco", STOPPING, mujoco_array("geom_priority", 0)),
    Pitfall("friction pyramid", "mujoco", "block: stopping distance askew", mujoco_option("cone", 0)),
    Pitfall("small inertias lifted", "mujoco", "tree: mass matrix", lifted_inertias),
    Pitfall("default softness of dry friction", "mujoco", "joint friction: creep at 85 %", default_friction_softness),
    Pitfall("default softness of contact", "mujoco", "block: resting height", default_contact),
    Pitfall("armature dropped", "mujoco", "armature: acceleration", no_armature),
)

# --- DART


def dart_asleep(s: Any) -> None:
    import dartpy

    options = dartpy.simulation.DeactivationOptions()
    options.mEnabled = True
    s._world.setDeactivationOptions(options)


def dart_kilogram(s: Any) -> None:
    import dartpy

    s._skeleton.getBodyNode(s._skeleton.getNumBodyNodes() - 1).setInertia(dartpy.dynamics.Inertia())


def dart_pyramid(s: Any) -> None:
    solver = s._world.getConstraintSolver()
    solver.setBoxedLcpSolver(solver.getSecondaryBoxedLcpSolver())


def dart_slippery(s: Any) -> None:
    for i in range(s._skeleton.getNumBodyNodes()):
        body = s._skeleton.getBodyNode(i)
        for k in range(body.getNumShapeNodes()):
            body.getShapeNode(k).getDynamicsAspect().setFrictionCoeff(0.5)


def dart_speed_limits(s: Any) -> None:
    for i, joint in enumerate(s.model.joints):
        made = s._skeleton.getJoint(i + 1)
        made.setVelocityLowerLimit(0, -joint.velocity)
        made.setVelocityUpperLimit(0, joint.velocity)


DART = (
    Pitfall("sleeping on", "dart", "no sleep: slow motion on the ground", dart_asleep),
    Pitfall("a link of 1 kg", "dart", "tree: total mass", dart_kilogram),
    Pitfall("default solver's friction pyramid", "dart", "block: stopping distance askew", dart_pyramid),
    Pitfall("friction is the smaller of the pair", "dart", STOPPING, dart_slippery),
    Pitfall("speed limits come with position limits", "dart", "tree: one real step", dart_speed_limits),
    Pitfall("armature dropped", "dart", "armature: acceleration", law(native_armature=True)),
)

# --- Drake


def drake_no_rotor(s: Any) -> None:
    for joint in s.model.joints:
        s._plant.GetJointActuatorByName(joint.name).SetRotorInertia(s._plant_context, 0.0)


def drake_kilogram(s: Any) -> None:
    s._plant.GetBodyByName(s.model.links[-1].name).SetMass(s._plant_context, 1.0)


DRAKE = (
    Pitfall("armature dropped", "drake", "armature: acceleration", drake_no_rotor),
    Pitfall("a link of 1 kg", "drake", "tree: total mass", drake_kilogram),
)

# --- all


class Wrong:
    """A simulation that forwards to a real one, apart from what a subclass gets wrong."""

    def __init__(self, real: Simulation) -> None:
        self._step = real.step
        real.step = self.step  # type: ignore[method-assign]
        self.model, self.steps = real.model, 0

    def step(self, effort: Array, damping: Array, friction: Array) -> None:
        raise NotImplementedError


class ActsOnUrdf(Wrong):
    """The URDF's effort limit clamps, and its damping and friction act beside those of the step."""

    def step(self, effort: Array, damping: Array, friction: Array) -> None:
        limit, own = [np.array([getattr(j, k) for j in self.model.joints]) for k in ("effort", "damping")]
        self._step(np.clip(effort, -limit, limit), damping + own, friction)


class ClampsEffort(Wrong):
    def step(self, effort: Array, damping: Array, friction: Array) -> None:
        limit = np.array([j.effort for j in self.model.joints])
        self._step(np.clip(effort, -limit, limit), damping, friction)


class ForgetsEffort(Wrong):
    """The effort acts in the first step only, as where it has to be applied anew and is not."""

    def step(self, effort: Array, damping: Array, friction: Array) -> None:
        self.steps += 1
        self._step(effort if self.steps == 1 else np.zeros_like(effort), damping, friction)


class OtherOrder(Wrong):
    def step(self, effort: Array, damping: Array, friction: Array) -> None:
        self._step(effort[::-1], damping[::-1], friction[::-1])


def welded(model: Model) -> Model:
    return replace(model, floating=False) if model.joints else model


ALL = tuple(
    pitfall
    for name in engines.available()
    for pitfall in (
        Pitfall("root welded", name, "tree: mass matrix", model=welded),
        Pitfall("URDF damping left on", name, FREE_SPIN, ActsOnUrdf),
        Pitfall("URDF effort clamps", name, "strong effort is not clipped", ClampsEffort),
        Pitfall("effort not applied anew", name, "armature: acceleration", ForgetsEffort),
        Pitfall("joints in another order", name, "arm: 10 ms under constant effort", OtherOrder),
    )
)


@pytest.mark.parametrize("pitfall", [*PYBULLET, *MUJOCO, *DART, *DRAKE, *ALL], ids=lambda p: f"{p.engine}: {p.what}")
def test_the_audit_names_what_broke(pitfall: Pitfall) -> None:
    if pitfall.engine not in engines.available():
        pytest.skip(f"{pitfall.engine} is not installed")
    fails(Spoiled(pitfall.engine, pitfall.spoil, pitfall.model), pitfall.fails)
