"""Does it move as it must? Free motion against closed forms, and what engines silently do to it."""

from dataclasses import replace

import numpy as np
from realitygap_engines import GRAVITY, Diverged, Engine, Ground, Physics, State
from realitygap_engines.model.robot import Array, Model
from scipy.special import ellipk

from realitygap.audit.check import Check, advance, largest, read
from realitygap.audit.machines import BLOCK_HEIGHT, INERTIA, STEP, at_rest, block, pendulum, random_state, rotor, tree
from realitygap.audit.oracle import Oracle

AMPLITUDE = 1.0
BLOWN_UP = 1e4
"""A speed [rad/s] that no robot has: an engine that shows it hides no blow-up."""


def _swing(engine: Engine, steps: int) -> tuple[Array, Array]:
    """Angle and velocity of the pendulum let go at rest at `AMPLITUDE`. Shape (steps + 1,) each."""
    with engine.open(pendulum(), Physics(STEP)) as simulation:
        simulation.reset(at_rest(AMPLITUDE))
        rows = [read(simulation)] + [advance(simulation) for _ in range(steps)]
    return np.array([r.position[0] for r in rows]), np.array([r.velocity[0] for r in rows])


def _pendulum() -> tuple[float, float]:
    """Inertia about the hinge [kg·m²] and gravity torque when horizontal [N·m]."""
    bob = pendulum().links[1]
    length = -bob.com[2]
    return bob.inertia[1, 1] + bob.mass * length**2, bob.mass * GRAVITY * length


def period(engine: Engine) -> float:
    """T = 4 K(k) sqrt(I/mgl), k = sin(amplitude/2) (Landau, Lifshitz, Mechanics, section 11)."""
    inertia, torque = _pendulum()
    expected = 4 * ellipk(np.sin(AMPLITUDE / 2) ** 2) * np.sqrt(inertia / torque)
    q, _ = _swing(engine, 4000)
    down = np.flatnonzero((q[:-1] > 0) & (q[1:] <= 0))
    if len(down) < 2:
        return float(np.inf)
    crossing = down + q[down] / (q[down] - q[down + 1])
    return float(abs(np.diff(crossing).mean() * STEP / expected - 1))


def energy(engine: Engine) -> float:
    """Energy with the velocity averaged over neighbours, which is that at the time of the position to order h²."""
    inertia, torque = _pendulum()
    q, w = _swing(engine, 4000)
    middle = 0.5 * (w[:-1] + w[1:])
    total = 0.5 * inertia * middle**2 - torque * np.cos(q[:-1])
    start = -torque * np.cos(AMPLITUDE)
    return float(np.abs(total[1:] - start).max() / (start + torque))


def free_fall(engine: Engine) -> float:
    """g·h²·n·(n + 1)/2 after n steps, under a gravity that is askew."""
    gravity, n = np.array([1.0, 2.0, -3.0]), 300
    body = replace(tree(), links=tree().links[:1], joints=())
    with engine.open(body, Physics(STEP, gravity=(1.0, 2.0, -3.0))) as simulation:
        end = advance(simulation, n)
    expected = gravity * STEP * STEP * n * (n + 1) / 2
    return float(np.abs(end.base_position - expected).max() / np.abs(expected).max())


def free_spin(engine: Engine) -> float:
    """A balanced wheel at 200 rad/s keeps its speed: no motor, no damping, no speed limit."""
    with engine.open(rotor(INERTIA), Physics(STEP)) as simulation:
        simulation.reset(State(np.zeros(1), np.array([200.0])))
        end = advance(simulation, 200)
    return float(abs(end.velocity[0] / 200.0 - 1))


def strong_effort(engine: Engine) -> float:
    """1000 N·m on a wheel whose joint states a limit of 1e-3 N·m: limits are the servo's."""
    with engine.open(rotor(INERTIA), Physics(1e-4)) as simulation:
        end = advance(simulation, effort=1000.0)
    return float(abs(end.velocity[0] / (1000.0 * 1e-4 / INERTIA) - 1))


def crawl(engine: Engine) -> float:
    """A wheel at 1e-3 rad/s, and a body that drifts at 1e-3 m/s, go on for 3 s: nothing falls asleep."""
    worst = 0.0
    with engine.open(rotor(INERTIA), Physics(STEP)) as simulation:
        simulation.reset(State(np.zeros(1), np.array([1e-3])))
        worst = abs(advance(simulation, 3000).position[0] / 3e-3 - 1)
    body = replace(tree(), links=tree().links[:1], joints=())
    with engine.open(body, Physics(STEP, gravity=(0.0, 0.0, 0.0))) as simulation:
        state = State(np.zeros(0), np.zeros(0))
        state.base_linear = np.array([1e-3, 0.0, 0.0])
        simulation.reset(state)
        worst = max(worst, abs(advance(simulation, 3000).base_position[0] / 3e-3 - 1))
    return float(worst)


def crawl_on_ground(engine: Engine) -> float:
    """A wheel at 1e-3 rad/s on a block that rests on the ground: engines put what rests to sleep first."""
    wheel, base = rotor(INERTIA), block()
    model = replace(base, links=(base.links[0], wheel.links[1]), joints=wheel.joints)
    with engine.open(model, Physics(STEP, ground=Ground(0.8))) as simulation:
        state = State(np.zeros(1), np.array([1e-3]))
        state.base_position = np.array([0.0, 0.0, BLOCK_HEIGHT])
        simulation.reset(state)
        return float(abs(advance(simulation, 3000).position[0] / 3e-3 - 1))


def _two_machines() -> tuple[Model, Model]:
    """Machines of one name, the second with 1.5 times the mass."""
    light = tree(False)
    links = tuple(replace(x, mass=1.5 * x.mass, inertia=1.5 * x.inertia) for x in light.links)
    return light, replace(light, links=links)


def side_by_side(engine: Engine) -> float:
    """Two machines that are open at once and stepped in turn move as each does alone."""
    models = _two_machines()
    efforts = np.random.default_rng(1).uniform(-0.02, 0.02, len(models[0].joints))
    alone, together = [], []
    for model in models:
        with engine.open(model, Physics(STEP)) as simulation:
            simulation.reset(random_state(model, 5))
            alone.append(advance(simulation, 20, effort=efforts).position)
    with engine.open(models[0], Physics(STEP)) as first, engine.open(models[1], Physics(STEP)) as second:
        first.reset(random_state(models[0], 5))
        second.reset(random_state(models[1], 5))
        for _ in range(20):
            together = [advance(s, effort=efforts).position for s in (first, second)]
    return float(max(np.abs(a - b).max() for a, b in zip(alone, together, strict=True)))


def one_after_the_other(engine: Engine) -> float:
    """The inertia of the second machine, opened after the first was closed."""
    worst = 0.0
    for model in _two_machines():
        state = random_state(model, 5)
        with engine.open(model, Physics(STEP)) as simulation:
            simulation.reset(state)
            worst = max(worst, largest(simulation.mass_matrix(), Oracle(model).inertia_and_bias(state)[0]))
    return worst


def blow_up(engine: Engine) -> float:
    """The number of blow-ups, of two, that pass for a result: too strong an effort, and one that is not a number."""
    unseen = 0
    for effort in (1e12, np.nan):
        with engine.open(rotor(1e-4, limit=np.inf), Physics(STEP)) as simulation:
            try:
                end = advance(simulation, 50, effort=effort)
            except Diverged:
                continue
            found = abs(end.velocity[0])
        unseen += bool(found < BLOWN_UP)
    return float(unseen)


CHECKS = (
    Check("pendulum: period", period, 1e-5, "1", "elliptic integral, 1 rad", "forward_dynamics"),
    Check("pendulum: energy", energy, 1e-4, "1", "4 s at 1 ms, relative to the swing", "forward_dynamics"),
    Check("free fall", free_fall, 1e-9, note="0.3 s under a skewed gravity"),
    Check("free spin", free_spin, 1e-9, note="200 rad/s for 0.2 s: no motor, damping or speed limit"),
    Check("strong effort is not clipped", strong_effort, 1e-6),
    Check("no sleep: slow motion", crawl, 1e-6, note="1e-3 rad/s and 1e-3 m/s for 3 s"),
    Check("no sleep: slow motion on the ground", crawl_on_ground, 1e-2, note="1e-3 rad/s for 3 s"),
    Check("a changed model is read anew", one_after_the_other, 1e-9, note="two masses, one name"),
    Check("two simulations at once", side_by_side, 1e-12, "rad", "two masses, one name"),
    Check("a blow-up is seen", blow_up, 0.0, "unseen", "1e12 N·m, and an effort that is not a number"),
)
