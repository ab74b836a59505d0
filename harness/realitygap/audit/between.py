"""The same motion in all engines, side by side."""

from dataclasses import replace

import numpy as np
from realitygap_engines import Diverged, Engine, Failed, Ground, Physics, State, Unsupported
from realitygap_engines.errors import as_its_outcome
from realitygap_engines.model.robot import Array, Model

from realitygap.audit.certificate import Proof, Verdict
from realitygap.audit.check import advance, read
from realitygap.audit.machines import STEP, at_rest, chain, leg, random_state
from realitygap.audit.oracle import Oracle

CHAIN_TOLERANCE = 1e-9
FREE_TOLERANCE = 1e-6
ARMATURE = 0.0266
GAIN, BACK_EMF = 25.0, 1.4


def chain_rows(engines: list[Engine]) -> list[Proof]:
    """A skewed 3-joint chain that swings freely for 1000 steps of 1 ms."""
    start = State(np.array([0.5, -0.3, 0.8]), np.array([0.5, -1.0, 0.7]))
    return _rows("chain: 1000 free steps", engines, chain(), start, STEP, 1000, CHAIN_TOLERANCE)


def free_rows(engines: list[Engine], model: Model, h: float) -> list[Proof]:
    """A tenth of a second of free flight of the user's own robot, from a state within its limits."""
    start = random_state(model, 1, fastest=0.3)
    return _rows("robot: 0.1 s of free motion", engines, model, start, h, round(0.1 / h), FREE_TOLERANCE)


def _rows(
    name: str, engines: list[Engine], model: Model, start: State, h: float, steps: int, tolerance: float
) -> list[Proof]:
    """One row per engine against Pinocchio under the same scheme (velocity first), one for the spread of all."""
    oracle, state, zero = Oracle(model), start, np.zeros(len(model.joints))
    for _ in range(steps):
        state = oracle.step(state, h, zero)
    rows, ends = [], []
    for engine in engines:
        try:
            with as_its_outcome(engine.name), engine.open(model, Physics(h)) as simulation:
                simulation.reset(start)
                end = advance(simulation, steps).position
        except (Diverged, Failed, Unsupported) as error:
            rows.append(Proof(name, engine.name, float("inf"), tolerance, "rad", "failed", str(error)))
            continue
        capability = engine.capabilities()["forward_dynamics"]
        row = _row(name, engine.name, end - state.position, tolerance, "against Pinocchio, velocity first")
        if row.verdict == "failed" and capability.level == "no":
            row = replace(row, verdict="declared", note=capability.how)
        else:
            ends.append(end)
        rows.append(row)
    if len(ends) > 1:
        spread = np.max(ends, axis=0) - np.min(ends, axis=0)
        rows.append(_row(name, "all", spread, tolerance, "between any two engines, without declared ones"))
    return rows


def _row(name: str, engine: str, error: Array, tolerance: float, note: str) -> Proof:
    worst = float(np.abs(error).max(initial=0.0))
    verdict: Verdict = "passed" if worst <= tolerance else "failed"
    return Proof(name, engine, worst, tolerance, "rad", verdict, note)


def contact_rows(engines: list[Engine]) -> list[Proof]:
    """A servo-driven leg that squats on the ground: each engine against MuJoCo, with and without rotor inertia.

    Information: with contact, engines differ. What armature adds to that difference is the error of its emulation.
    """
    reference = next((engine for engine in engines if engine.name == "mujoco"), None)
    others = [engine for engine in engines if engine is not reference]
    if reference is None or not others:
        return []
    rows = []
    for name, armature in (("leg on the ground, armature", ARMATURE), ("leg on the ground, no armature", 0.0)):
        judge = _squat(reference, armature)
        for engine in others:
            error = float(np.sqrt(np.mean((_squat(engine, armature) - judge) ** 2)))
            note = "rms of hip, knee and ankle over 1 s against MuJoCo's native armature at the same step"
            rows.append(Proof(name, engine.name, error, np.inf, "rad", "information", note))
    return rows


def _squat(engine: Engine, armature: float) -> Array:
    """Joint angles while dc-like servos follow a squat of 0.2 rad at 1 Hz. Shape (1000, 3)."""
    stance = np.array([-0.35, 0.7, -0.35])
    height = 0.2 * np.cos(0.35) * 2 + 0.035
    gain, damping = np.array([0.0, GAIN, GAIN, GAIN]), np.array([0.0, BACK_EMF, BACK_EMF, BACK_EMF])
    out = np.empty((1000, 3))
    with engine.open(leg(armature), Physics(STEP, ground=Ground(0.8))) as simulation:
        simulation.reset(at_rest(height, *stance))
        state = read(simulation)
        for k in range(len(out)):
            bend = 0.2 * (1 - np.cos(2 * np.pi * k * STEP)) / 2
            goal = np.concatenate([[0.0], stance + bend * np.array([-0.5, 1.0, -0.5])])
            state = advance(simulation, effort=gain * (goal - state.position), damping=damping)
            out[k] = state.position[1:]
    return out
