"""The bundled test machines: small robots whose motion is known, or hard to get right by accident."""

import numpy as np
from realitygap_engines import State
from realitygap_engines.model.robot import Array, Joint, Link, Model, Sphere, axis_rotation, rotation_from_rpy

STEP = 1e-3
"""The step [s] of every check that does not need another."""
INERTIA = 0.01
"""Of a rotor [kg·m²] that is no pitfall by its size."""
FAR = 50.0
"""A position limit [rad or m] that is never reached, so that engines have to enforce one."""


def tree(floating: bool = True) -> Model:
    """A branching robot with skewed axes, offset centres of mass, a prismatic joint and one very light link.

    Its joints state an effort, a velocity, friction and damping that an engine must not act on by itself: those are
    the servo's and the joint law's.
    """
    rng = np.random.default_rng(3)
    links, joints = [], []
    for i in range(7):
        axes = axis_rotation(np.array([0.6, 0.0, 0.8]), rng.uniform(-2, 2))
        a, b, c = rng.uniform(1e-3, 3e-3, 3)
        inertia = axes @ np.diag([b + c, a + c, a + b]) @ axes.T
        mass = rng.uniform(0.2, 1.5)
        com = rng.uniform(-0.1, 0.1, 3)
        scale = 0.02 if i == 5 else 1.0
        links.append(Link(f"link{i}", mass * scale, com, scale * (inertia + inertia.T) / 2))
    for i, parent in enumerate([0, 1, 2, 0, 4, 4]):
        origin = np.eye(4)
        origin[:3, :3] = rotation_from_rpy(*rng.uniform(-1, 1, 3))
        origin[:3, 3] = rng.uniform(-0.2, 0.2, 3)
        axis = rng.normal(size=3)
        axis /= np.linalg.norm(axis)
        joints.append(Joint(f"joint{i}", i == 3, parent, origin, axis, -FAR, FAR, 1e-3, 1e-3, 0.3, 0.5))
    return Model("tree", tuple(links), tuple(joints), floating)


def chain() -> Model:
    """Three links on skewed axes, hung from a fixed base."""
    model = tree(False)
    return Model("chain", model.links[:4], model.joints[:3], False)


def pendulum() -> Model:
    """0.5 kg that swing about y at 0.2 m, with an inertia of 1e-6 kg·m² about the centre of mass; 0 hangs down."""
    base = Link("base", 1.0, np.zeros(3), np.eye(3) * 1e-3)
    bob = Link("bob", 0.5, np.array([0.0, 0.0, -0.2]), np.eye(3) * 1e-6)
    return Model("pendulum", (base, bob), (Joint("hinge", False, 0, np.eye(4), np.array([0.0, 1.0, 0.0])),), False)


def rotor(inertia: float, *, armature: float = 0.0, limit: float = FAR) -> Model:
    """A wheel of that inertia [kg·m²] about z on a fixed base, balanced, so that gravity does not turn it."""
    base = Link("base", 1.0, np.zeros(3), np.eye(3) * 1e-3)
    wheel = Link("wheel", 0.5, np.zeros(3), np.diag([inertia, inertia, inertia]))
    axis = np.array([0.0, 0.0, 1.0])
    joint = Joint("axle", False, 0, np.eye(4), axis, -limit, limit, 1e-3, 1e-3, 0.3, 0.5, armature)
    return Model("rotor", (base, wheel), (joint,), False)


def block() -> Model:
    """A free box of 1.2 kg on four spheres, 0.2 m wide and flat, so that it slides rather than tumbles."""
    feet = tuple(Sphere(np.array([x, y, -0.01]), 0.01) for x in (-0.1, 0.1) for y in (-0.1, 0.1))
    return Model("block", (Link("block", 1.2, np.zeros(3), np.diag([4e-3, 4e-3, 8e-3]), feet),), (), True)


BLOCK_HEIGHT = 0.02
"""Height of the block's centre when it rests [m]."""


def leg(armature: float) -> Model:
    """A trunk of 3 kg on a vertical slide with hip, knee and ankle, whose foot of 60 g presses on the ground.

    The foot's inertia is as small as a humanoid's, 4.5e-4 kg·m², far below the armature of its servo.
    """
    y, z = np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0])
    sole = tuple(Sphere(np.array([x, w, -0.03]), 5e-3) for x in (-0.06, 0.08) for w in (-0.03, 0.03))
    links = (
        Link("base", 1.0, np.zeros(3), np.eye(3) * 1e-3),
        Link("trunk", 3.0, np.array([0.0, 0.0, 0.1]), np.eye(3) * 1e-2),
        Link("thigh", 0.4, np.array([0.0, 0.0, -0.1]), np.diag([2e-3, 2e-3, 2e-4])),
        Link("shank", 0.3, np.array([0.0, 0.0, -0.1]), np.diag([1.5e-3, 1.5e-3, 2e-4])),
        Link("foot", 0.06, np.array([0.01, 0.0, -0.02]), np.diag([2e-4, 4.5e-4, 4e-4]), sole),
    )
    down = np.eye(4)
    down[2, 3] = -0.2
    joints = (
        Joint("slide", True, 0, np.eye(4), z),
        Joint("hip", False, 1, np.eye(4), y, armature=armature),
        Joint("knee", False, 2, down, y, armature=armature),
        Joint("ankle", False, 3, down, y, armature=armature),
    )
    return Model("leg", links, joints, False)


def random_state(model: Model, seed: int, *, slowest: float = 0.0, fastest: float = 2.0) -> State:
    """A random state, with joint speeds of random sign between the two [rad/s or m/s]."""
    rng = np.random.default_rng(seed)
    n = len(model.joints)
    quaternion = rng.normal(size=4)
    return State(
        position=rng.uniform(-1, 1, n),
        velocity=rng.uniform(slowest, fastest, n) * rng.choice([-1.0, 1.0], n),
        base_position=rng.uniform(-1, 1, 3) if model.floating else np.zeros(3),
        base_quaternion=quaternion / np.linalg.norm(quaternion),
        base_linear=rng.uniform(-1, 1, 3) if model.floating else np.zeros(3),
        base_angular=rng.uniform(-1, 1, 3) if model.floating else np.zeros(3),
    )


def at_rest(*position: float) -> State:
    """Joint positions [rad or m] at rest, the base at the origin."""
    n = len(position)
    return State(np.array(position, dtype=float), np.zeros(n))


def velocities(model: Model, state: State) -> Array:
    """All velocities of a state in the coordinates of `Simulation.mass_matrix`. Shape (nv,)."""
    base = np.concatenate([state.base_linear, state.base_angular]) if model.floating else np.zeros(0)
    return np.concatenate([base, state.velocity])
