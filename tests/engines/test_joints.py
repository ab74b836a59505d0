"""The joint law: its own dynamics against Pinocchio, its equation, and closed forms in every engine."""

from dataclasses import replace
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
import realitygap_engines as engines
import trees
from realitygap_engines import Ground, Physics, State
from realitygap_engines.law.dynamics import Dynamics
from realitygap_engines.law.joints import JointLaw
from realitygap_engines.model.robot import (
    Array,
    Joint,
    Link,
    Model,
    Sphere,
    rotation_from_quaternion,
)
from realitygap_engines.model.urdf import write_urdf

NAMES = engines.available()
OUTSIDE = [name for name in NAMES if name != "mujoco"]  # dry friction by `realitygap_engines.law.joints`
GRAVITY = np.array([0.0, 0.0, -9.81])


def tree(floating: bool) -> Model:
    """Two branches with light links, and rotors that differ."""
    return trees.tree([0, 1, 0, 3, 4], floating, seed=5, moments=(1e-4, 1e-3)).with_armature(np.linspace(0, 0.04, 5))


def lever(**joint: Any) -> Model:
    """One link of 0.01 kg·m² about a vertical hinge on a fixed base: gravity has no say."""
    arm = Link("arm", 1.0, np.zeros(3), np.eye(3) * 0.01)
    hinge = Joint("hinge", False, 0, np.eye(4), np.array([0.0, 0.0, 1.0]), **joint)
    return Model("lever", (Link("base", 1.0, np.zeros(3), np.eye(3) * 1e-3), arm), (hinge,), False)


def state_of(model: Model, seed: int) -> tuple[Array, Array, Array]:
    rng = np.random.default_rng(seed)
    n = len(model.joints)
    base = rng.normal(size=13) if model.floating else np.zeros(13)
    base[3:7] = rng.normal(size=4) if model.floating else (1.0, 0.0, 0.0, 0.0)
    base[3:7] /= np.linalg.norm(base[3:7])
    return rng.uniform(-2, 2, n), rng.uniform(-2, 2, n), base


@pytest.mark.parametrize("floating", [False, True])
@pytest.mark.parametrize("seed", range(4))
def test_inertia_and_bias_are_pinocchios(floating: bool, seed: int) -> None:
    model = tree(floating)
    q, v, base = state_of(model, seed)
    dynamics = Dynamics(model)
    dynamics.update(q, v, base, GRAVITY)
    oracle = pin.buildModelFromXML(write_urdf(model), *([pin.JointModelFreeFlyer()] if floating else []))
    data, o = oracle.createData(), 6 if floating else 0
    order = [*range(o), *(oracle.joints[oracle.getJointId(name)].idx_v for name in model.joint_names)]
    angles, rates, drift, turn = np.zeros(o + 5), np.zeros(o + 5), np.zeros(o + 5), np.eye(o + 5)
    angles[order[o:]], rates[order[o:]] = q, v
    position = pin.integrate(oracle, pin.neutral(oracle), angles)
    if floating:
        r = rotation_from_quaternion(base[3:7])
        position[:3], position[3:7] = base[:3], base[[4, 5, 6, 3]]
        rates[:3], rates[3:6] = r.T @ base[7:10], r.T @ base[10:]
        drift[:3] = -np.cross(rates[3:6], rates[:3])  # Pinocchio's base acceleration is that of the turning axes
        turn[:3, :3] = turn[3:6, 3:6] = r.T
    mass = pin.crba(oracle, data, position)
    mass = np.triu(mass) + np.triu(mass, 1).T
    bias = pin.rnea(oracle, data, position, rates, drift)
    np.testing.assert_allclose(dynamics.inertia, (turn.T @ mass @ turn)[np.ix_(order, order)], rtol=0, atol=1e-12)
    np.testing.assert_allclose(dynamics.bias, (turn.T @ bias)[order], rtol=0, atol=1e-12 * np.abs(bias).max())


@pytest.mark.parametrize("floating", [False, True])
@pytest.mark.parametrize("seed", range(6))
def test_an_engine_without_anything_comes_out_as_the_law_asks(floating: bool, seed: int) -> None:
    """The equation of the law at v', dry friction within its bound, against the motion and holding where it can."""
    model, h = tree(floating), 1e-3
    law = JointLaw(model, Physics(timestep=h), native_armature=False, native_damping=False)
    q, v, base = state_of(model, seed)
    v[seed % 5] = 0.0
    rng = np.random.default_rng(seed)
    effort, damping, friction = rng.uniform(-1, 1, 5), rng.uniform(0, 2, 5), rng.uniform(0, 3, 5)
    given = law.effort(q, v, base, effort, damping, friction)
    dynamics = Dynamics(model)
    dynamics.update(q, v, base, GRAVITY)
    o = 6 if floating else 0
    full = np.concatenate([np.zeros(o), given])
    change = np.linalg.solve(dynamics.inertia, full - dynamics.bias)  # an engine without armature
    after = v + h * change[o:]
    wanted = effort - damping * after + law.dry - model.armature * change[o:]
    np.testing.assert_allclose(given, wanted, rtol=0, atol=1e-9)
    assert (np.abs(law.dry) <= friction).all()
    stuck = np.abs(after) < 1e-10
    np.testing.assert_allclose(law.dry[~stuck], (-np.sign(after) * friction)[~stuck], rtol=0, atol=1e-12)


def test_nothing_to_add_hands_the_effort_through() -> None:
    law = JointLaw(lever(), Physics(), native_armature=False, native_damping=False)
    effort, zero = np.array([0.3]), np.zeros(1)
    assert law.effort(zero, zero, np.zeros(13), effort, zero, zero) is effort


@pytest.mark.parametrize("value", [np.nan, np.inf, 1e300])
def test_a_state_that_blew_up_ends_the_step(value: float) -> None:
    model = tree(True)
    law = JointLaw(model, Physics(ground=Ground()), native_armature=False, native_damping=False)
    q, v, base = state_of(model, 0)
    v[2] = value
    assert not np.isfinite(law.effort(q, v, base, v, np.ones(5), np.ones(5))).all()


def run(name: str, model: Model, speed: float, effort: float, damping: float, friction: float, steps: int) -> Array:
    """The speed of the lever after every step of 1 ms."""
    position, velocity, base, out = np.zeros(1), np.zeros(1), np.zeros(13), []
    with engines.load(name).open(model, Physics()) as simulation:
        simulation.reset(State(np.zeros(1), np.array([speed])))
        for _ in range(steps):
            simulation.step(np.array([effort]), np.array([damping]), np.array([friction]))
            simulation.read(position, velocity, base)
            out.append(velocity[0])
    return np.array(out)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("damping", [0.0, 0.5, 200.0])
def test_armature_and_damping_are_those_of_the_closed_form(name: str, damping: float) -> None:
    """(I + A) (v' - v)/h = tau - D v', at any size of D."""
    inertia, h = 0.01 + 0.03, 1e-3
    expected, speed = [], 2.0
    for _ in range(50):
        speed = (inertia * speed + h * 0.2) / (inertia + h * damping)
        expected.append(speed)
    np.testing.assert_allclose(run(name, lever(armature=0.03), 2.0, 0.2, damping, 0.0, 50), expected, rtol=1e-9)


@pytest.mark.parametrize("name", NAMES)
def test_a_sliding_joint_slows_and_then_stays(name: str) -> None:
    """It loses F/I in speed per second, as m a = -F, and stops."""
    speed = run(name, lever(), 1.0, 0.0, 0.0, 0.05, 400)
    time = 1e-3 * np.arange(1, 401)
    tolerance = 1e-9 if name in OUTSIDE else 1e-2  # MuJoCo's friction is a soft constraint
    np.testing.assert_allclose(speed, np.maximum(1.0 - 5.0 * time, 0.0), rtol=0, atol=tolerance)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("sign", [-1, 1])
def test_a_stuck_joint_stays_below_breakaway_and_leaves_above(name: str, sign: int) -> None:
    assert np.abs(run(name, lever(armature=0.02), 0.0, sign * 0.085, 0.0, 0.1, 300)).max() < 1e-3
    moved = run(name, lever(armature=0.02), 0.0, sign * 0.11, 0.0, 0.1, 100)
    assert moved[-1] == pytest.approx(sign * 0.01 / 0.03 * 0.1, rel=1e-6 if name in OUTSIDE else 5e-2)


def ankle() -> Model:
    """A body of 5 kg on an ankle with a light foot: 4.5e-4 kg·m² behind an armature of 0.0266."""
    foot = tuple(Sphere(np.array([x, y, -0.02]), 0.01) for x in (-0.06, 0.08) for y in (-0.04, 0.04))
    links = (
        Link("body", 5.0, np.array([0.0, 0.0, 0.2]), np.diag([0.05, 0.05, 0.02])),
        Link("shank", 0.1, np.zeros(3), np.eye(3) * 1e-4),
        Link("foot", 0.15, np.array([0.01, 0.0, -0.01]), np.diag([2e-4, 4.5e-4, 4.5e-4]), foot),
    )
    pitch = Joint("pitch", False, 0, np.eye(4), np.array([0.0, 1.0, 0.0]), armature=0.0266)
    roll = Joint("roll", False, 1, np.eye(4), np.array([1.0, 0.0, 0.0]), armature=0.0266)
    return Model("ankle", links, (pitch, roll), True)


def sway(name: str, model: Model, rate: float, amplitude: float, height: float) -> Array:
    """Joint positions every 10 ms of the body that sways on its foot, from a drop of that height."""
    position, velocity, base, out = np.zeros(2), np.zeros(2), np.zeros(13), []
    start = State(np.zeros(2), np.zeros(2), np.array([0.0, 0.0, 0.03 + height]))
    with engines.load(name).open(model, Physics(ground=Ground(0.8))) as simulation:
        simulation.reset(start)
        for i in range(1500):
            simulation.read(position, velocity, base)
            if i % 10 == 0:
                out.append(position.copy())
            goal = amplitude * np.sin(rate * 1e-3 * i) * np.array([1.0, 0.5])
            simulation.step(40.0 * (goal - position), np.full(2, 0.3), np.full(2, 0.02))
    return np.array(out)


@pytest.mark.parametrize("name", OUTSIDE)
@pytest.mark.parametrize(
    ("rate", "amplitude", "height", "bound"), [(20.0, 0.02, 0.0, 1e-4), (12.0, 0.05, 0.03, 2.5e-3)]
)
def test_a_light_foot_behind_a_rotor_moves_as_where_armature_is_native(
    name: str, rate: float, amplitude: float, height: float, bound: float
) -> None:
    """Standing within 0.1 mrad rms of MuJoCo; landing and tipping within what engines differ by in an impact."""
    native = sway("mujoco", ankle(), rate, amplitude, height)
    without = sway("mujoco", ankle().with_armature(np.zeros(2)), rate, amplitude, height)
    assert np.sqrt(np.mean((without - native) ** 2)) > 5 * bound  # so the rotors matter here
    assert np.sqrt(np.mean((sway(name, ankle(), rate, amplitude, height) - native) ** 2)) < bound


def test_ballast_carries_what_the_armature_asks_for_and_leaves_the_rest_alone() -> None:
    model = ankle()
    law = JointLaw(model, Physics(ground=Ground()), native_armature=False, native_damping=False, ballast=True)
    added = [new.inertia - old.inertia for new, old in zip(law.model.links, model.links, strict=True)]
    np.testing.assert_allclose(added, [np.zeros((3, 3)), np.zeros((3, 3)), 0.0266 * np.eye(3)], atol=1e-12)
    q, v, base = state_of(model, 3)
    heavy, light = Dynamics(law.model), Dynamics(model)
    for dynamics in (heavy, light):
        dynamics.update(q, v, base, GRAVITY)
    matrix, bias = law.ballast(q, v, base)
    np.testing.assert_allclose(matrix, heavy.inertia - light.inertia, rtol=0, atol=1e-12)
    np.testing.assert_allclose(bias, heavy.bias - light.bias, rtol=0, atol=1e-11)
    without = replace(model, joints=tuple(replace(j, armature=0.0) for j in model.joints))
    assert not JointLaw(without, Physics(), native_armature=False, native_damping=False, ballast=True).ballasted
