"""Damping, dry friction, armature and limits of one joint against closed forms."""

import numpy as np
from realitygap_engines import Engine, Physics, State

from realitygap.audit.check import Check, advance, speeds
from realitygap.audit.machines import INERTIA, STEP, at_rest, rotor

LIGHT = 4.5e-4
"""Inertia of a humanoid's foot about its ankle [kg·m²]."""
FRICTION = 0.02


def decay(engine: Engine) -> float:
    """exp(-D t/I), at a step that is short against I/D."""
    h, damping, steps = 1e-4, 0.05, 2000
    with engine.open(rotor(INERTIA), Physics(h)) as simulation:
        simulation.reset(State(np.zeros(1), np.ones(1)))
        found = speeds(simulation, steps, damping=damping)
    expected = np.exp(-damping * h * np.arange(1, steps + 1) / INERTIA)
    return float(np.abs(found - expected).max())


def stiff_decay(engine: Engine) -> float:
    """v/(1 + h D/I) per step: the back-EMF of a servo on a foot, where an explicit damping explodes."""
    damping = 1.4
    with engine.open(rotor(LIGHT), Physics(STEP)) as simulation:
        simulation.reset(State(np.zeros(1), np.ones(1)))
        found = speeds(simulation, 10, damping=damping)
    expected = (1 + STEP * damping / LIGHT) ** -np.arange(1.0, 11.0)
    return float(np.abs(found - expected).max())


def slowing(engine: Engine) -> float:
    """v - F t/I until it stands, and then stands."""
    steps = 700
    with engine.open(rotor(INERTIA), Physics(STEP)) as simulation:
        simulation.reset(State(np.zeros(1), np.ones(1)))
        found = speeds(simulation, steps, friction=FRICTION)
    expected = np.maximum(1.0 - FRICTION * STEP * np.arange(1, steps + 1) / INERTIA, 0.0)
    return float(np.abs(found - expected).max())


def creep(engine: Engine) -> float:
    """The speed at which 85 % of the breakaway torque moves the joint."""
    with engine.open(rotor(INERTIA), Physics(STEP)) as simulation:
        simulation.reset(at_rest(0.0))
        found = speeds(simulation, 500, effort=0.85 * FRICTION, friction=FRICTION)
    return float(np.abs(found).max())


def breakaway(engine: Engine) -> float:
    """Twice the breakaway torque accelerates with (effort - F)/I."""
    steps = 200
    with engine.open(rotor(INERTIA), Physics(STEP)) as simulation:
        simulation.reset(at_rest(0.0))
        end = advance(simulation, steps, effort=2 * FRICTION, friction=FRICTION)
    return float(abs(end.velocity[0] / (FRICTION / INERTIA * steps * STEP) - 1))


def armature(engine: Engine) -> float:
    """Acceleration effort/(I + A) of a foot behind a servo's rotor, sixty times its inertia."""
    rotor_inertia, steps, effort = 0.0266, 100, 0.5
    with engine.open(rotor(LIGHT, armature=rotor_inertia), Physics(STEP)) as simulation:
        found = speeds(simulation, steps, effort=effort)
    expected = effort * STEP * np.arange(1, steps + 1) / (LIGHT + rotor_inertia)
    return float(np.abs(found / expected - 1).max())


def limit(engine: Engine) -> float:
    """How far an effort of 0.5 N·m presses the joint off its limit, after it ran into it at 1 rad/s."""
    bound = 0.3
    with engine.open(rotor(INERTIA, limit=bound), Physics(STEP)) as simulation:
        simulation.reset(State(np.array([0.2]), np.ones(1)))
        advance(simulation, 100, effort=0.5)
        found = [advance(simulation, effort=0.5).position[0] for _ in range(400)]
    return float(np.abs(np.array(found) - bound).max())


def overshoot(engine: Engine) -> float:
    """How far a joint at 3 rad/s gets beyond its limit."""
    bound = 0.3
    with engine.open(rotor(INERTIA, limit=bound), Physics(STEP)) as simulation:
        simulation.reset(State(np.array([0.2]), np.array([3.0])))
        found = [advance(simulation).position[0] for _ in range(100)]
    return float(max(max(found) - bound, 0.0))


CHECKS = (
    Check("joint damping: exponential decay", decay, 1e-3, "rad/s", "exp(-D t/I), 1 rad/s", "joint_damping"),
    Check("joint damping: stiff, implicit", stiff_decay, 1e-6, "rad/s", "1.4 N·m·s/rad on a foot", "joint_damping"),
    Check("joint friction: linear decay", slowing, 2e-3, "rad/s", "v - F t/I, then rest", "joint_friction"),
    Check("joint friction: creep at 85 %", creep, 1e-3, "rad/s", "of the breakaway torque", "joint_friction"),
    Check("joint friction: breakaway", breakaway, 1e-3, "1", "twice the breakaway torque", "joint_friction"),
    Check("armature: acceleration", armature, 1e-6, "1", "effort/(I + A), A 60 times I", "armature"),
    Check("joint limit: holds", limit, 1e-3, "rad", "0.5 N·m against it", "joint_limits"),
    Check("joint limit: overshoot", overshoot, 5e-3, "rad", "at 3 rad/s, 3e-3 a step", "joint_limits"),
)
