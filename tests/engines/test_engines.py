"""Laws that hold in every engine: the same machine, the same contact, the same result every time."""

import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
import realitygap_engines as engines
import trees
from realitygap_engines import Ground, Physics, Simulation, State
from realitygap_engines.model.robot import (
    Array,
    Joint,
    Link,
    Model,
    Sphere,
    rotation_from_quaternion,
)

NAMES = engines.available()
GRAVITY = 9.81


EXACT = [name for name in NAMES if engines.load(name).capabilities()["forward_dynamics"].level == "native"]
"""Engines whose step is forward dynamics; what the others do instead is tested beside their adapters."""


def every(*names: str) -> pytest.MarkDecorator:
    return pytest.mark.parametrize("name", names or NAMES)


def tree(floating: bool, seed: int = 3) -> Model:
    return trees.tree([0, 1, 2, 0, 4, 4], floating, seed=seed)


def feet(model: Model) -> Model:
    """The tree with spheres to touch the ground with on its base and two of its links."""
    links = [
        replace(x, spheres=(Sphere(x.com, 0.03), Sphere(-x.com, 0.02))) if i in (0, 3, 5) else x
        for i, x in enumerate(model.links)
    ]
    return replace(model, links=tuple(links))


def chain() -> Model:
    """Three links on skewed axes, hung from a fixed base."""
    model = tree(False, seed=8)
    return Model("chain", model.links[:4], model.joints[:3], False)


def pendulum(length: float = 0.2) -> Model:
    """A point mass of 0.5 kg that swings about y, q = 0 hanging down."""
    base = Link("base", 1.0, np.zeros(3), np.eye(3) * 1e-3)
    bob = Link("bob", 0.5, np.array([0.0, 0.0, -length]), np.eye(3) * 1e-6)
    return Model("pendulum", (base, bob), (Joint("hinge", False, 0, np.eye(4), np.array([0.0, 1.0, 0.0])),), False)


def block() -> Model:
    """A free box on four spheres, 0.2 m wide and flat, so that it slides rather than tumbles."""
    feet = tuple(Sphere(np.array([x, y, -0.01]), 0.01) for x in (-0.1, 0.1) for y in (-0.1, 0.1))
    return Model("block", (Link("block", 1.2, np.zeros(3), np.diag([4e-3, 4e-3, 8e-3]), feet),), (), True)


def random_state(model: Model, seed: int) -> State:
    rng = np.random.default_rng(seed)
    n = len(model.joints)
    q = rng.normal(size=4)
    return State(
        rng.uniform(-1, 1, n),
        rng.uniform(-2, 2, n),
        rng.uniform(-1, 1, 3),
        q / np.linalg.norm(q),
        rng.uniform(-1, 1, 3),
        rng.uniform(-1, 1, 3),
    )


def step(simulation: Simulation, effort: Array | None = None, steps: int = 1) -> State:
    """Advance without damping and friction and read back."""
    n = len(simulation.model.joints)
    zero = np.zeros(n)
    for _ in range(steps):
        simulation.step(zero if effort is None else effort, zero, zero)
    return read(simulation)


def read(simulation: Simulation) -> State:
    n = len(simulation.model.joints)
    position, velocity, base = np.zeros(n), np.zeros(n), np.zeros(13)
    simulation.read(position, velocity, base)
    return State(position, velocity, base[:3], base[3:7], base[7:10], base[10:])


class Oracle:
    """The same model in Pinocchio, in the coordinates of `Simulation.mass_matrix`."""

    def __init__(self, model: Model) -> None:
        self.model = model
        self.pin = pin.Model()
        self.pin.gravity.linear = np.array([0.0, 0.0, -GRAVITY])
        ids = [self.pin.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "root") if model.floating else 0]
        for joint in model.joints:
            kind = pin.JointModelPrismaticUnaligned if joint.prismatic else pin.JointModelRevoluteUnaligned
            ids.append(self.pin.addJoint(ids[joint.parent], kind(joint.axis), pin.SE3(joint.origin), joint.name))
        for link, i in zip(model.links, ids, strict=True):
            self.pin.appendBodyToJoint(i, pin.Inertia(link.mass, link.com, link.inertia), pin.SE3.Identity())
        self.data = self.pin.createData()
        starts = [self.pin.joints[i].idx_v for i in ids[1:]]
        self.order = np.array([*range(6 if model.floating else 0), *starts])

    def matrices(self, state: State) -> tuple[Array, Array]:
        """Mass matrix and bias at a state, base first, in world axes."""
        o = 6 if self.model.floating else 0
        turn = np.eye(self.pin.nv)
        q, v, drift = np.zeros(self.pin.nq), np.zeros(self.pin.nv), np.zeros(self.pin.nv)
        joints = self.order[o:]
        q[joints + (1 if o else 0)] = state.position
        v[joints] = state.velocity
        if o:
            r = rotation_from_quaternion(state.base_quaternion)
            q[:3], q[3:7] = state.base_position, np.roll(state.base_quaternion, -1)
            turn[:3, :3] = turn[3:6, 3:6] = r.T
            v[:3], v[3:6] = r.T @ state.base_linear, r.T @ state.base_angular
            drift[:3] = -np.cross(v[3:6], v[:3])  # Pinocchio's base acceleration is that of the turning body axes
        mass = pin.crba(self.pin, self.data, q)
        mass = np.triu(mass) + np.triu(mass, 1).T
        bias = turn.T @ (mass @ drift + pin.nonLinearEffects(self.pin, self.data, q, v))
        mass = turn.T @ mass @ turn
        return mass[np.ix_(self.order, self.order)], bias[self.order]


@every()
@pytest.mark.parametrize("floating", [False, True])
@pytest.mark.parametrize("armature", [0.0, 0.02])
def test_mass_matrix_and_bias_are_the_oracles(name: str, floating: bool, armature: float) -> None:
    """With armature in the matrix where that is native, and without a trace of what stands for it elsewhere."""
    model = feet(tree(floating)).with_armature(np.full(6, armature))
    oracle = Oracle(model)
    tolerance = 1e-8 if name == "pybullet" else 1e-9
    engine = engines.load(name)
    native = armature if engine.capabilities()["armature"].level == "native" else 0.0
    rotors = np.diag(np.concatenate([np.zeros(6 if floating else 0), np.full(6, native)]))
    with engine.open(model, Physics(ground=Ground())) as simulation:
        for seed in range(5):
            state = random_state(model, seed)
            if not floating:
                state.base_position, state.base_quaternion = np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0])
            simulation.reset(state)
            mass, bias = oracle.matrices(state)
            np.testing.assert_allclose(simulation.mass_matrix(), mass + rotors, rtol=0, atol=tolerance)
            np.testing.assert_allclose(simulation.bias(), bias, rtol=0, atol=tolerance * 100)


@every(*EXACT)
@pytest.mark.parametrize("floating", [False, True])
def test_one_real_step_is_forward_dynamics(name: str, floating: bool) -> None:
    model = tree(floating)
    oracle = Oracle(model)
    h = 1e-4
    with engines.load(name).open(model, Physics(timestep=h)) as simulation:
        for seed in range(5):
            state = random_state(model, seed)
            if not floating:
                state.base_position, state.base_quaternion = np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0])
            effort = np.random.default_rng(seed).uniform(-1, 1, len(model.joints))
            simulation.reset(state)
            after = step(simulation, effort)
            mass, bias = oracle.matrices(state)
            full = np.concatenate([np.zeros(6 if floating else 0), effort])
            expected = np.linalg.solve(mass, full - bias)
            found = (after.velocity - state.velocity) / h
            if floating:
                base = np.concatenate([after.base_linear - state.base_linear, after.base_angular - state.base_angular])
                found = np.concatenate([base / h, found])
            np.testing.assert_allclose(found, expected, rtol=0, atol=1e-6 * np.abs(expected).max())


@every()
@pytest.mark.parametrize("floating", [False, True])
def test_reset_is_read_back(name: str, floating: bool) -> None:
    model = tree(floating)
    with engines.load(name).open(model, Physics(ground=Ground())) as simulation:
        for seed in range(3):
            state = random_state(model, seed)
            simulation.reset(state)
            found = read(simulation)
            np.testing.assert_allclose(found.position, state.position, atol=1e-12)
            np.testing.assert_allclose(found.velocity, state.velocity, atol=1e-12)
            if floating:
                np.testing.assert_allclose(found.base_position, state.base_position, atol=1e-12)
                sign = np.sign(found.base_quaternion @ state.base_quaternion)
                np.testing.assert_allclose(sign * found.base_quaternion, state.base_quaternion, atol=1e-12)
                np.testing.assert_allclose(found.base_linear, state.base_linear, atol=1e-12)
                np.testing.assert_allclose(found.base_angular, state.base_angular, atol=1e-12)


@every()
def test_a_fixed_base_stands_as_it_was_reset(name: str) -> None:
    """A pendulum on a base that is pitched by a quarter turn falls with g/l from q = 0."""
    model = pendulum()
    half = np.sqrt(0.5)
    state = State(np.zeros(1), np.zeros(1), np.array([0.0, 0.0, 2.0]), np.array([half, 0.0, half, 0.0]))
    with engines.load(name).open(model, Physics(timestep=1e-4)) as simulation:
        simulation.reset(state)
        after = step(simulation)
        inertia = 0.5 * 0.2**2 + 1e-6
        assert after.velocity[0] / 1e-4 == pytest.approx(-0.5 * GRAVITY * 0.2 / inertia, rel=1e-6)


def swing(name: str) -> Array:
    """A trace of the floating tree falling on the ground, with all of the joint law, as an array."""
    model = feet(tree(True)).with_armature(np.full(6, 0.02))
    state = random_state(model, 1)
    state.base_position[2] = 0.6
    rows = []
    with engines.load(name).open(model, Physics(ground=Ground(0.6))) as simulation:
        for _ in range(2):  # again after a reset, in the same simulation
            simulation.reset(state)
            for _ in range(300):
                before = read(simulation)
                simulation.step(-before.position, np.full(6, 0.05), np.full(6, 0.1))
                after = read(simulation)
                rows.append(
                    np.concatenate(
                        [after.position, after.velocity, after.base_position, after.base_linear, after.base_angular]
                    )
                )
    return np.array(rows)


@every()
def test_reset_rerun_and_a_new_process_are_bit_identical(name: str, tmp_path: Path) -> None:
    first = swing(name)
    np.testing.assert_array_equal(first[:300], first[300:])
    np.testing.assert_array_equal(first, swing(name))
    code = (
        "import importlib.util, sys, numpy\n"
        f"spec = importlib.util.spec_from_file_location('laws', {__file__!r})\n"
        "laws = importlib.util.module_from_spec(spec); spec.loader.exec_module(laws)\n"
        f"numpy.save({str(tmp_path / 'trace.npy')!r}, laws.swing({name!r}))\n"
    )
    known = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    subprocess.run(
        [sys.executable, "-c", code], check=True, capture_output=True, cwd=Path(__file__).parents[2], env=known
    )
    np.testing.assert_array_equal(first, np.load(tmp_path / "trace.npy"))


@every()
def test_pendulum_period_is_that_of_the_closed_form(name: str) -> None:
    """Small swings of a physical pendulum: T = 2 pi sqrt(I / m g l)."""
    h, length = 1e-3, 0.2
    period = 2 * np.pi * np.sqrt((0.5 * length**2 + 1e-6) / (0.5 * GRAVITY * length))
    with engines.load(name).open(pendulum(length), Physics(timestep=h)) as simulation:
        simulation.reset(State(np.array([0.01]), np.zeros(1)))
        q = np.array([step(simulation).position[0] for _ in range(3000)])
    down = np.flatnonzero((q[:-1] > 0) & (q[1:] <= 0))
    crossings = down + q[down] / (q[down] - q[down + 1])
    assert np.diff(crossings).mean() * h == pytest.approx(period, rel=1e-4)
    assert np.abs(q[-900:]).max() == pytest.approx(0.01, rel=1e-3)  # energy neither lost nor won


def test_a_skewed_chain_moves_alike_in_all_exact_engines() -> None:
    model = chain()
    start = State(np.array([0.5, -0.3, 0.8]), np.array([0.5, -1.0, 0.7]))
    ends = {}
    for name in EXACT:
        with engines.load(name).open(model, Physics(timestep=1e-3)) as simulation:
            simulation.reset(start)
            ends[name] = step(simulation, steps=1000).position
    for name, end in ends.items():
        np.testing.assert_allclose(end, ends[EXACT[0]], rtol=0, atol=1e-9, err_msg=f"{name} and {EXACT[0]}")


@every()
@pytest.mark.parametrize("friction", [0.3, 0.9])
@pytest.mark.parametrize("heading", [0.0, 22.5, 45.0])
def test_a_sliding_block_stops_where_the_closed_form_says(name: str, friction: float, heading: float) -> None:
    """Straight ahead for v²/(2 mu g) and half a step, with the friction of the pair, whatever the direction."""
    h, speed = 1e-3, 1.0
    with engines.load(name).open(block(), Physics(timestep=h, ground=Ground(friction))) as simulation:
        state = State(np.zeros(0), np.zeros(0))
        state.base_position[2] = 0.02
        simulation.reset(state)
        step(simulation, steps=200)  # settle
        state = read(simulation)
        ahead = np.array([np.cos(np.radians(heading)), np.sin(np.radians(heading)), 0.0])
        state.base_linear = speed * ahead
        start = state.base_position
        simulation.reset(state)
        end = step(simulation, steps=1000)
    expected = speed**2 / (2 * friction * GRAVITY)
    moved = end.base_position - start
    assert moved @ ahead == pytest.approx(expected, abs=h * speed)
    assert np.abs(moved - (moved @ ahead) * ahead).max() < 3e-3 * expected
    assert np.abs(end.base_linear).max() < 2e-3


@every()
def test_a_block_rests_on_the_ground(name: str) -> None:
    with engines.load(name).open(block(), Physics(ground=Ground(0.8))) as simulation:
        state = State(np.zeros(0), np.zeros(0))
        state.base_position[2] = 0.02
        simulation.reset(state)
        end = step(simulation, steps=1000)
    assert end.base_position[2] == pytest.approx(0.02, abs=1e-4)
    assert np.abs(end.base_linear).max() < 1e-4


@every()
def test_without_ground_everything_falls(name: str) -> None:
    h, n = 1e-3, 500
    with engines.load(name).open(block(), Physics(timestep=h)) as simulation:
        end = step(simulation, steps=n)
    assert end.base_position[2] == pytest.approx(-GRAVITY * h * h * n * (n + 1) / 2, rel=1e-9)


@every()
def test_settings_and_capabilities_are_declared(name: str) -> None:
    engine = engines.load(name)
    assert engine.name == name
    assert engine.version
    capabilities = engine.capabilities()
    assert sorted(capabilities) == sorted(engines.engine.CAPABILITIES)
    assert {c.level for c in capabilities.values()} <= {"native", "emulated", "no"}
    with engine.open(block(), Physics(solver_iterations=50, ground=Ground(0.5))) as simulation:
        assert simulation.settings
        assert any("iteration" in key for key in simulation.settings)


@every()
def test_gravity_is_the_one_asked_for(name: str) -> None:
    with engines.load(name).open(block(), Physics(gravity=(1.0, 2.0, -3.0))) as simulation:
        end = step(simulation)
    np.testing.assert_allclose(end.base_linear, np.array([1.0, 2.0, -3.0]) * 1e-3, atol=1e-12)
