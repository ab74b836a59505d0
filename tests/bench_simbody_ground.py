"""What Simbody's own contact models are worth on the contract's ground, beside the ground law that the adapter uses.

Two closed forms at the harness's step: a block on a slope at 85 % of what slides stays where it is, and a ball that
drops from 0.1 m neither sinks in nor comes back. The models are forces of the state at the beginning of the step, with
a spring of Hertz in place of the contract's linear one, and friction that grows with the slip up to a transition
velocity. The exponential model has a rest point for friction, but its parameters cannot be set from Python.

    python tests/bench_simbody_ground.py
"""

import itertools

import numpy as np
import opensim
import realitygap_engines as engines
from realitygap_engines import Ground, Physics, State
from realitygap_engines.model.robot import Array, Link, Model, Sphere

H, G, FRICTION = 1e-3, 9.81, 0.8
SLOPE = (0.85 * FRICTION * G, 0.0, -G)
LEVEL = (0.0, 0.0, -G)
RADIUS, DROP, SECONDS = 0.01, 0.1, 1.0
DISSIPATION = 2.0
MODULI = (1e6, 1e7, 1e8, 1e9)
"""[Pa] of the half space, up to where the ball flies off."""
TRANSITIONS = (1e-3, 4e-3, 1e-2)
"""[m/s] Below friction·g·step/2 = 3.9e-3 friction throws the block to and fro."""
LIMIT = 1e3
"""What is farther off than this [m or m/s] has blown up."""


def body(feet: int) -> Model:
    """1.2 kg on four spheres, or on one."""
    at = [(x, y, 0.0) for x in (-0.1, 0.1) for y in (-0.1, 0.1)] if feet == 4 else [(0.0, 0.0, 0.0)]
    spheres = tuple(Sphere(np.array(place), RADIUS) for place in at)
    return Model("body", (Link("body", 1.2, np.zeros(3), np.diag([4e-3, 4e-3, 8e-3]), spheres),), (), True)


def native(kind: str, model: Model, gravity: tuple[float, ...], modulus: float, transition: float) -> "opensim.Model":
    """The body in OpenSim, on one of its contact models."""
    tree, zero, link = opensim.Model(), opensim.Vec3(0.0), model.links[0]
    tree.setGravity(opensim.Vec3(*gravity))
    made = opensim.Body("body", link.mass, zero, opensim.Inertia(*np.diag(link.inertia).tolist()))
    tree.addBody(made)
    tree.addJoint(opensim.FreeJoint("base", tree.getGround(), zero, zero, made, zero, zero))
    plane = opensim.ContactHalfSpace(zero, opensim.Vec3(0.0, np.pi / 2, 0.0), tree.getGround(), "ground")
    tree.addContactGeometry(plane)
    for i, sphere in enumerate(link.spheres):
        foot = opensim.ContactSphere(sphere.radius, opensim.Vec3(*sphere.center.tolist()), made, f"foot{i}")
        tree.addContactGeometry(foot)
        if kind == "SmoothSphereHalfSpace":
            force = opensim.SmoothSphereHalfSpaceForce(f"force{i}", foot, plane)
            for name, value in (("stiffness", modulus), ("dissipation", DISSIPATION), ("static_friction", FRICTION)):
                getattr(force, f"set_{name}")(value)
            force.set_dynamic_friction(FRICTION)
            force.set_transition_velocity(transition)
        else:
            force = opensim.HuntCrossleyForce()
            force.addGeometry("ground")
            force.addGeometry(f"foot{i}")
            force.setStiffness(modulus)
            force.setDissipation(DISSIPATION)
            force.setStaticFriction(FRICTION)
            force.setDynamicFriction(FRICTION)
            force.setTransitionVelocity(transition)
        force.setName(f"force{i}")
        tree.addForce(force)
    return tree


def moved(tree: "opensim.Model", height: float) -> Array:
    """Place and velocity after every step of a start at rest at that height. Shape (steps, 6)."""
    state = tree.initSystem()
    q, u, rows = np.zeros(state.getNQ()), np.zeros(state.getNU()), []
    q[5] = height
    for _ in range(round(SECONDS / H)):
        state.setQ(opensim.Vector.createFromMat(q))
        state.setU(opensim.Vector.createFromMat(u))
        tree.realizeAcceleration(state)
        u = u + H * state.getUDot().to_numpy()
        q[:6] += H * u  # nothing turns by more than a little, so that the angles' rates are the angular velocity
        rows.append(np.concatenate([q[3:6], u[3:6]]))
        if not np.abs(rows[-1]).max() < LIMIT:
            break
    return np.array(rows)


def by_law(model: Model, gravity: tuple[float, float, float], height: float) -> Array:
    """The same from the adapter."""
    none, base, rows = np.zeros(0), np.zeros(13), []
    with engines.load("simbody").open(model, Physics(H, ground=Ground(FRICTION), gravity=gravity)) as simulation:
        simulation.reset(State(none, none, np.array([0.0, 0.0, height])))
        for _ in range(round(SECONDS / H)):
            simulation.step(none, none, none)
            simulation.read(none, none, base)
            rows.append(np.concatenate([base[:3], base[7:10]]))
    return np.array(rows)


def row(name: str, block: Array, ball: Array) -> str:
    """What both did: creep of the block over its second half, and the ball's depth and way back."""
    whole = round(SECONDS / H)
    if len(block) < whole or len(ball) < whole:
        return f"| {name} | blew up | | | |"
    creep = abs(block[-1, 0] - block[whole // 2, 0]) / (SECONDS / 2)
    deepest, rest = RADIUS - ball[:, 2].min(), RADIUS - ball[-1, 2]
    back = ball[:, 5].max() / np.sqrt(2 * G * DROP)
    return f"| {name} | {creep:.1e} | {deepest:.1e} | {rest:.1e} | {max(back, 0.0):.2f} |"


def main() -> None:
    """Print the table."""
    block, ball = body(4), body(1)
    print("| model | creep of the block, m/s | ball: deepest, m | at rest, m | speed back / speed of impact |")
    print("|---|---|---|---|---|")
    print(row("law.ground", by_law(block, SLOPE, RADIUS), by_law(ball, LEVEL, RADIUS + DROP)))
    for kind, modulus, speed in itertools.product(("HuntCrossley", "SmoothSphereHalfSpace"), MODULI, TRANSITIONS):
        slid = moved(native(kind, block, SLOPE, modulus, speed), RADIUS)
        fell = moved(native(kind, ball, LEVEL, modulus, speed), RADIUS + DROP)
        print(row(f"{kind}, {modulus:g} Pa, {speed:g} m/s", slid, fell))


if __name__ == "__main__":
    main()
