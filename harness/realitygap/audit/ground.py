"""Contact with the ground: resting height, friction of the pair, stiffness."""

import numpy as np
from realitygap_engines import GRAVITY, Engine, Ground, Physics, Simulation, State, Unsupported
from realitygap_engines.model.robot import Array

from realitygap.audit.check import Check, advance, read
from realitygap.audit.machines import BLOCK_HEIGHT, STEP, block

STIFFNESS, DAMPING = 3000.0, 100.0


def _standing() -> State:
    state = State(np.zeros(0), np.zeros(0))
    state.base_position = np.array([0.0, 0.0, BLOCK_HEIGHT])
    return state


def rest(engine: Engine) -> float:
    """Height above the ground after half a second."""
    with engine.open(block(), Physics(STEP, ground=Ground(0.8))) as simulation:
        simulation.reset(_standing())
        end = advance(simulation, 500)
    return float(abs(end.base_position[2] - BLOCK_HEIGHT))


def sink(engine: Engine) -> float:
    """Depth m g/(4 k) on soft ground, relative; an engine without stiffness shows what rigid ground gives."""
    depth = block().mass * GRAVITY / (4 * STIFFNESS)
    try:
        simulation = engine.open(block(), Physics(STEP, ground=Ground(0.8, STIFFNESS, DAMPING)))
    except Unsupported:
        simulation = engine.open(block(), Physics(STEP, ground=Ground(0.8)))
    with simulation:
        simulation.reset(_standing())
        end = advance(simulation, 1000)
    return float(abs((BLOCK_HEIGHT - end.base_position[2]) / depth - 1))


def _slide(simulation: Simulation, friction: float, heading: float) -> tuple[float, float]:
    """Errors [m] of the distance along v²/(2 mu g), and across, of a block sent off at 1 m/s."""
    ahead = np.array([np.cos(heading), np.sin(heading), 0.0])
    simulation.reset(_standing())
    advance(simulation, 100)  # settle
    state = read(simulation)
    state.base_linear = ahead
    start: Array = state.base_position.copy()
    simulation.reset(state)
    moved = advance(simulation, round(1.2 / (friction * GRAVITY * STEP))).base_position - start
    expected = 1.0 / (2 * friction * GRAVITY) - STEP / 2  # velocities are stepped before positions
    along = float(moved @ ahead)
    return abs(along - expected), float(np.abs(moved - along * ahead).max())


def stopping(engine: Engine) -> float:
    """Stopping distance of the block for two coefficients of the pair, relative."""
    worst = 0.0
    for friction in (0.3, 0.9):
        with engine.open(block(), Physics(STEP, ground=Ground(friction))) as simulation:
            worst = max(worst, _slide(simulation, friction, 0.0)[0] * 2 * friction * GRAVITY)
    return worst


def heading(engine: Engine) -> float:
    """The same at 45° and 22.5°, with the distance that it is led astray: a friction pyramid shows here."""
    worst = 0.0
    with engine.open(block(), Physics(STEP, ground=Ground(0.6))) as simulation:
        for angle in (np.pi / 4, np.pi / 8):
            worst = max(worst, *_slide(simulation, 0.6, angle))
    return worst * 2 * 0.6 * GRAVITY


CHECKS = (
    Check("block: resting height", rest, 1e-4, "m", capability="rigid_ground"),
    Check("block: stopping distance", stopping, 5e-3, "1", "v²/(2 µ g), pair µ 0.3 and 0.9", "rigid_ground"),
    Check("block: stopping distance askew", heading, 5e-3, "1", "at 22.5° and 45°", "rigid_ground"),
    Check("block: depth on soft ground", sink, 2e-2, "1", "m g/(4 k), k 3000 N/m", "soft_ground"),
)
