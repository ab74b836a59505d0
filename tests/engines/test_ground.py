"""Soft ground in every engine that has it: a spring and damper per point, friction, and nothing of the joints in it."""

from dataclasses import replace

import numpy as np
import pytest
import realitygap_engines as engines
from realitygap_engines import Ground, Physics, State
from realitygap_engines.model.robot import Array, Joint, Link, Model, Sphere, rotation_from_quaternion

H = 1e-3
GRAVITY = 9.81
SOFT = [n for n in engines.available() if engines.load(n).capabilities()["soft_ground"].level != "no"]
EXACT = [n for n in SOFT if n != "ode"]
"""ODE sweeps towards its answer, and is measured in tests of its own."""
every = pytest.mark.parametrize("name", EXACT)


def block() -> Model:
    """A free box of 1.2 kg on four spheres, flat, so that it slides rather than tumbles."""
    feet = tuple(Sphere(np.array([x, y, -0.01]), 0.01) for x in (-0.1, 0.1) for y in (-0.1, 0.1))
    return Model("block", (Link("block", 1.2, np.zeros(3), np.diag([4e-3, 4e-3, 8e-3]), feet),), (), True)


def stool() -> Model:
    """A seat on a leg that slides up and down through it, with the block for a foot; light, and far from isotropic."""
    foot = block().links[0]
    seat = Link("seat", 2.0, np.zeros(3), np.diag([2e-2, 2e-2, 3e-2]))
    origin = np.eye(4)
    origin[2, 3] = -0.2
    leg = Joint("leg", True, 0, origin, np.array([0.0, 0.0, 1.0]))
    return Model("stool", (seat, replace(foot, mass=0.3, inertia=foot.inertia / 4)), (leg,), True)


def fall(name: str, ground: Ground, height: float, speed: float, steps: int) -> tuple[Array, Array]:
    """Height of the block's soles and vertical speed after every step."""
    none, base, rows = np.zeros(0), np.zeros(13), []
    with engines.load(name).open(block(), Physics(H, ground=ground)) as simulation:
        simulation.reset(State(none, none, np.array([0, 0, 0.02 + height]), base_linear=np.array([0, 0, speed])))
        for _ in range(steps):
            simulation.step(none, none, none)
            simulation.read(none, none, base)
            rows.append((base[2] - 0.02, base[9]))
    return np.array([z for z, _ in rows]), np.array([v for _, v in rows])


@every
@pytest.mark.parametrize(("stiffness", "damping"), [(3000.0, 100.0), (3000.0, 0.0), (2e4, 20.0)])
def test_a_point_is_a_spring_and_damper_at_the_end_of_the_step(name: str, stiffness: float, damping: float) -> None:
    """Implicit Euler of m·v' = -m·g + 4·max(0, -k·z - b·v) with z and v at the end of the step, once z < 0."""
    mass, k, b = 1.2, 4 * stiffness, 4 * damping
    found_z, found_v = fall(name, Ground(0.8, stiffness, damping), 0.0013, -0.2, 150)
    z, v = 0.0013, -0.2
    for i in range(150):
        free = v - H * GRAVITY
        held = (mass * free - H * k * z) / (mass + H * b + H * H * k)
        v = held if z < 0 and -k * (z + H * held) - b * held > 0 else free
        z += H * v
        # MuJoCo's contact has 1e-4 of the body's inertia besides; PyBullet's is there one step before the surface
        assert found_z[i] == pytest.approx(z, abs=2e-4 if name == "pybullet" else 5e-6)
        assert found_v[i] == pytest.approx(v, abs=3e-2 if name == "pybullet" else 5e-4)


@every
@pytest.mark.parametrize("damping", [0.0, 30.0])
def test_a_bounce_adds_no_energy(name: str, damping: float) -> None:
    ground = Ground(0.8, 3000.0, damping)
    z, v = fall(name, ground, 0.05, 0.0, 1500)
    top = [z[:300].max(), z[300:].max()]  # the first bounce is over after 0.25 s
    assert top[1] < top[0]
    energy = 1.2 * (v**2 / 2 + GRAVITY * z) + 4 * 3000.0 * np.minimum(z, 0) ** 2 / 2
    assert energy[-300:].max() < energy[0]


@every
@pytest.mark.parametrize("damping", [5.0, 50.0])
def test_damping_of_a_joint_does_not_change_the_ground(name: str, damping: float) -> None:
    """The stool's foot sinks by the weight of all over the stiffness of four points, however its joint is damped."""
    ground = Ground(0.8, 3000.0, 100.0)
    position, velocity, base = np.zeros(1), np.zeros(1), np.zeros(13)
    with engines.load(name).open(stool(), Physics(H, ground=ground)) as simulation:
        simulation.reset(State(np.zeros(1), np.zeros(1), np.array([0, 0, 0.22])))
        for _ in range(1500):
            # a spring carries the seat
            simulation.step(-400.0 * position - 2.0 * GRAVITY, np.array([damping]), np.zeros(1))
            simulation.read(position, velocity, base)
    foot = base[2] - 0.2 + position[0] - 0.02
    assert foot == pytest.approx(-2.3 * GRAVITY / (4 * 3000.0), rel=2e-3)


@every
@pytest.mark.parametrize("damping", [0.0, 100.0])
def test_friction_holds_on_a_slope(name: str, damping: float) -> None:
    """At 85 % of what slides, a block on soft ground creeps by less than 1e-3 m/s, damped or not."""
    slope = (0.85 * 0.8 * GRAVITY, 0.0, -GRAVITY)
    none, base = np.zeros(0), np.zeros(13)
    with engines.load(name).open(block(), Physics(H, ground=Ground(0.8, 3000.0, damping), gravity=slope)) as simulation:
        simulation.reset(State(none, none, np.array([0, 0, 0.02 - 1.2 * GRAVITY / (4 * 3000.0)])))
        at = []
        for _ in range(1000):
            simulation.step(none, none, none)
            simulation.read(none, none, base)
            at.append(base[0])
    assert abs(at[-1] - at[499]) / 0.5 < 1e-3


@every
@pytest.mark.parametrize("friction", [0.3, 0.8])
def test_a_block_slides_as_far_as_on_rigid_ground(name: str, friction: float) -> None:
    """v²/(2 mu g), within what the convex contact of Drake and MuJoCo presses more on a damped point that slides."""
    none, base = np.zeros(0), np.zeros(13)
    with engines.load(name).open(block(), Physics(H, ground=Ground(friction, 3000.0, 100.0))) as simulation:
        low = np.array([0, 0, 0.02 - 1.2 * GRAVITY / (4 * 3000.0)])
        simulation.reset(State(none, none, low, base_linear=np.array([1.0, 0, 0])))
        for _ in range(800):
            simulation.step(none, none, none)
            simulation.read(none, none, base)
    assert base[0] == pytest.approx(1 / (2 * friction * GRAVITY), rel=1e-2 if name in ("dart", "pybullet") else 2.5e-2)
    assert abs(base[7]) < 1e-3


CORNERS = [0.05 * np.array([x, y, z]) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]


def cube() -> Link:
    """A cube of 0.4 kg on its corners."""
    return Link("cube", 0.4, np.zeros(3), np.eye(3) * 8e-4, tuple(Sphere(c, 1e-3) for c in CORNERS))


def lowest(attitude: Array) -> float:
    """The height of its lowest point, from its centre [m]."""
    return float(min((rotation_from_quaternion(attitude) @ c)[2] for c in CORNERS) - 1e-3)


def tumbling(name: str, ground: Ground, drop: float, velocity: Array, h: float, steps: int) -> Array:
    """Velocity of the base after every step, of a cube that falls onto one corner. Shape (steps, 3)."""
    none, base, rows = np.zeros(0), np.zeros(13), []
    attitude = np.array([0.9, 0.2, 0.3, 0.1])
    attitude /= np.linalg.norm(attitude)
    with engines.load(name).open(Model("cube", (cube(),), (), True), Physics(h, ground=ground)) as simulation:
        start = np.array([0.0, 0.0, drop - lowest(attitude)])
        simulation.reset(State(none, none, start, attitude, base_linear=np.asarray(velocity)))
        for _ in range(steps):
            simulation.step(none, none, none)
            simulation.read(none, none, base)
            rows.append(base[7:10].copy())
    return np.array(rows)


@pytest.mark.parametrize("name", SOFT)
@pytest.mark.parametrize("velocity", [(1.0, 0.0, -1.0), (0.6, 0.8, -1.0)])
def test_the_friction_of_a_sliding_impact_is_coulombs(name: str, velocity: tuple[float, float, float]) -> None:
    """The force along the ground is the coefficient times the normal force in whichever direction the corner slides."""
    h = 1e-4
    v = tumbling(name, Ground(0.2, 3000.0, 50.0), 1e-4, np.array(velocity), h, 150)
    force = 0.4 * (np.diff(v, axis=0) / h + [0, 0, GRAVITY])
    pressed = force[:, 2] > 1.0  # N: not where it comes and goes
    assert pressed.sum() > 50
    assert np.hypot(force[pressed, 0], force[pressed, 1]) == pytest.approx(0.2 * force[pressed, 2], rel=0.01)


@pytest.mark.parametrize("name", engines.available())
def test_rigid_ground_does_not_throw_a_body_back(name: str) -> None:
    """Whatever meets the ground at 1 m/s, at any time between two steps, leaves it at less than a third of that."""
    for height in np.linspace(2e-4, 1.2e-3, 6):
        assert fall(name, Ground(), height, -1.0, 20)[1].max() < 0.33, height


@pytest.mark.parametrize("name", engines.available())
def test_an_impact_on_rigid_ground_is_braked_by_no_more_than_friction(name: str) -> None:
    """Over the whole impact, wherever between two steps it begins. ODE's bound is up to a tenth low."""
    for drop in np.linspace(2e-4, 1.2e-3, 6):
        v = tumbling(name, Ground(0.2), drop, np.array([1.0, 0.0, -1.0]), H, 6)
        x, y, z = v[-1] - [1.0, 0.0, -1.0 - 6 * H * GRAVITY]
        assert np.hypot(x, y) == pytest.approx(0.2 * z, rel=0.1 if name == "ode" else 0.01), drop


@pytest.mark.parametrize("name", engines.available())
def test_a_cube_gains_nothing_on_rigid_ground_however_it_lands(name: str) -> None:
    """Its corners land two, three and four at a time, and slide. MuJoCo's comes back by a hundredth of what it had."""
    rng, none, base = np.random.default_rng(0), np.zeros(0), np.zeros(13)
    with engines.load(name).open(Model("cube", (cube(),), (), True), Physics(H, ground=Ground(0.2))) as simulation:
        for toss in range(40):
            attitude = rng.normal(size=4)
            attitude /= np.linalg.norm(attitude)
            start = np.array([0.0, 0.0, 0.02 - lowest(attitude)])
            speed, spin = np.array([*rng.uniform(-1, 1, 2), -0.5]), rng.uniform(-6, 6, 3)
            simulation.reset(State(none, none, start, attitude, base_linear=speed, base_angular=spin))
            energy = []
            for _ in range(300):
                simulation.step(none, none, none)
                simulation.read(none, none, base)
                energy.append(0.2 * base[7:10] @ base[7:10] + 4e-4 * base[10:] @ base[10:] + 0.4 * GRAVITY * base[2])
            assert np.max(energy - np.minimum.accumulate(energy)) < 0.01 * energy[0], toss
