"""Is it the same machine? Mass, inertia, bias and real steps of a model against Pinocchio."""

from dataclasses import replace

import numpy as np
from realitygap_engines import Engine, Physics, State
from realitygap_engines.model.robot import Array, Model

from realitygap.audit.check import Check, advance, largest, read
from realitygap.audit.machines import STEP, random_state, velocities
from realitygap.audit.oracle import Oracle

SEEDS = range(3)


def checks_of(model: Model, what: str, h: float = STEP, way_tolerance: float = 1e-3) -> tuple[Check, ...]:
    """The checks of one machine, named `what` in the certificate, at a step of h [s]."""
    bare = model.with_armature(np.zeros(len(model.joints)))
    oracle = Oracle(bare)
    many = len(SEEDS)

    def mass(engine: Engine) -> float:
        free = replace(bare, floating=True)
        with engine.open(free, Physics(h)) as simulation:
            inertia = simulation.mass_matrix()
        return largest(inertia[:3, :3], model.mass * np.eye(3))

    def inertia(engine: Engine) -> float:
        with engine.open(bare, Physics(h)) as simulation:
            worst = 0.0
            for state in _states(bare):
                simulation.reset(state)
                worst = max(worst, largest(simulation.mass_matrix(), oracle.inertia_and_bias(state)[0]))
        return worst

    def gravity(engine: Engine) -> float:
        with engine.open(bare, Physics(h)) as simulation:
            worst = 0.0
            for state in map(_stopped, _states(bare)):
                simulation.reset(state)
                worst = max(worst, largest(simulation.bias(), oracle.inertia_and_bias(state)[1]))
        return worst

    def coriolis(engine: Engine) -> float:
        with engine.open(bare, Physics(h)) as simulation:
            worst = 0.0
            for state in _states(bare):
                found, expected = [], []
                for s in (state, _stopped(state)):
                    simulation.reset(s)
                    found.append(simulation.bias())
                    expected.append(oracle.inertia_and_bias(s)[1])
                worst = max(worst, largest(found[0] - found[1], expected[0] - expected[1]))
        return worst

    def state_back(engine: Engine) -> float:
        with engine.open(bare, Physics(h)) as simulation:
            worst = 0.0
            for state in _states(bare):
                simulation.reset(state)
                worst = max(worst, _distance(bare, read(simulation), state))
        return worst

    def step(engine: Engine) -> float:
        return _step_error(engine, bare, oracle, h, law=False)

    def law_step(engine: Engine) -> float:
        full = model if model.armature.any() else model.with_armature(_inertias(oracle, bare))
        return _step_error(engine, full, Oracle(full), h, law=True)

    def way(engine: Engine) -> float:
        return _way_error(engine, bare, oracle)

    states = f"at {many} random states"
    stepping = "forward_dynamics" if model.joints else "lone_body"
    return (
        Check(f"{what}: total mass", mass, 1e-9, note="by the inertia matrix of the base, set free"),
        Check(f"{what}: mass matrix", inertia, 1e-9, note=states),
        Check(f"{what}: gravity", gravity, 1e-9, note=states),
        Check(f"{what}: Coriolis", coriolis, 1e-9, note=states),
        Check(f"{what}: state set and read", state_back, 1e-9, note=states),
        Check(f"{what}: one real step", step, 1e-6, "1", f"against forward dynamics, {states}", stepping),
        Check(
            f"{what}: one step of the joint law",
            law_step,
            1e-6,
            "1",
            f"armature, damping and friction, all joints sliding, {states}",
            stepping,
        ),
        Check(
            f"{what}: 10 ms under constant effort", way, way_tolerance, "1", "change of velocity, at a step of 0.1 ms"
        ),
    )


def _states(model: Model) -> list[State]:
    return [random_state(model, seed, slowest=0.5) for seed in SEEDS]


def _stopped(state: State) -> State:
    return State(state.position, np.zeros_like(state.velocity), state.base_position, state.base_quaternion)


def _inertias(oracle: Oracle, model: Model) -> Array:
    """The inertia that each joint feels with all else free [kg·m² or kg], at one state. Shape (n,)."""
    mass = oracle.inertia_and_bias(random_state(model, 0))[0]
    felt: Array = 1 / np.diag(np.linalg.inv(mass))[len(mass) - len(model.joints) :]
    return felt


def _step_error(engine: Engine, model: Model, oracle: Oracle, h: float, *, law: bool) -> float:
    """Acceleration over one step, relative to its largest entry.

    An engine may step the velocity of the base's origin or of its centre of mass: both are exact to order h, and
    nothing but the base's own acceleration tells them apart.
    """
    n = len(model.joints)
    felt = _inertias(oracle, model)
    worst = 0.0
    with engine.open(model, Physics(h)) as simulation:
        for seed in SEEDS:
            state = random_state(model, seed, slowest=0.5)
            effort = felt * np.random.default_rng(seed).uniform(-20, 20, n)
            damping, friction = (felt * 5.0, felt * 10.0) if law else (np.zeros(n), np.zeros(n))
            simulation.reset(state)
            after = advance(simulation, effort=effort, damping=damping, friction=friction)
            start = velocities(model, state)
            found = (velocities(model, after) - start) / h
            errors = []
            for point in (np.zeros(3), model.links[0].com):
                expected = oracle.step(state, h, effort, damping, friction, point=point)
                errors.append(largest(found, (velocities(model, expected) - start) / h))
            worst = max(worst, min(errors))
    return worst


def _way_error(engine: Engine, model: Model, oracle: Oracle) -> float:
    """Change of velocity over 100 steps of 0.1 ms, relative: small also where an engine has an error of order h."""
    h, steps = 1e-4, 100
    start = random_state(model, 0)
    effort = _inertias(oracle, model) * np.random.default_rng(0).uniform(-20, 20, len(model.joints))
    expected = start
    for _ in range(steps):
        expected = oracle.step(expected, h, effort)
    with engine.open(model, Physics(h)) as simulation:
        simulation.reset(start)
        found = advance(simulation, steps, effort=effort)
    gained = velocities(model, expected) - velocities(model, start)
    return float(np.abs(velocities(model, found) - velocities(model, expected)).max() / np.abs(gained).max())


def _distance(model: Model, found: State, expected: State) -> float:
    worst = largest(velocities(model, found), velocities(model, expected))
    worst = max(worst, largest(found.position, expected.position))
    if model.floating:
        sign = np.sign(found.base_quaternion @ expected.base_quaternion)
        worst = max(worst, largest(sign * found.base_quaternion, expected.base_quaternion))
        worst = max(worst, largest(found.base_position, expected.base_position))
    return worst
