"""Recordings with a planted effect: a scenario's own motions, noise and stamps, simulated with what its model lacks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from realitygap.diagnose.candidates.starts import guess
from realitygap.diagnose.candidates.suspects import bounds, neutral, whole
from realitygap.diagnose.data.case import Case
from realitygap.diagnose.data.changes import Change, Suspect
from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.data.push import Push
from realitygap.diagnose.data.windows import cut
from realitygap.diagnose.likelihood.floors import Floors
from realitygap.recording.quantum import quantum
from realitygap.robot.drive import Array
from realitygap.scenario.world import PhysicsSpec
from realitygap.simulate.experiment import simulate
from realitygap.trace.trace import Trace

FINER = 4.0
"""Recordings are simulated with this many times the step rate of the diagnosing simulation."""


def planted(problem: Problem, suspect: Suspect, factor: float) -> Change:
    """A suspect at some times its first size. Values that leave the effect's bounds are put back to them."""
    effect, first = suspect.kind, guess(problem, suspect)
    zero, values, within = neutral(problem.plant, suspect), first.parameters, bounds(problem.plant, suspect)
    for p in effect.parameters:
        if p.shape:
            continue
        if whole(effect) or not np.isfinite(zero[p.name]):
            value = values[p.name] / factor  # a limit or a stiffness: the lower, the more it does
        else:
            value = zero[p.name] + factor * (values[p.name] - zero[p.name])
        values[p.name] = float(np.clip(value, *within[p.name]))
    return first.at(values)


def plant_recordings(
    problem: Problem, floors: Floors, changes: Sequence[Change], engine: str, seed: int = 0
) -> Problem:
    """A copy of a problem in which what was measured is simulated with changes, in an engine and with a finer step.

    Args:
        problem: the motions.
        floors: of the model, which say how noisy its sensors are and what disturbs it.
        changes: what the simulated robot has and the model lacks.
        engine: that plays the robot.
        seed: of the noise.

    Raises:
        Unsupported, Diverged: as the engine says.
    """
    random = np.random.default_rng(seed)
    cases = [_recorded(problem, floors, changes, i, engine, random) for i in range(len(problem.cases))]
    return replace(problem, cases=tuple(cases))


def _recorded(
    problem: Problem, floors: Floors, changes: Sequence[Change], number: int, engine: str, random: np.random.Generator
) -> Case:
    case = problem.cases[number]
    e, plant = case.experiment, problem.changed_plant(changes, number)
    rate = e.scenario.physics.step_rate * FINER
    fast = replace(e, scenario=e.scenario.model_copy(update={"physics": physics_at(e.scenario.physics, rate)}))
    for j in np.flatnonzero(floors.torque > 0):
        Push(int(j), floors.torque[j] / np.sqrt(case.repetitions), int(random.integers(1 << 31))).on(plant, fast)
    trace = simulate(e.with_plant(plant), engine, step_rate=rate).trace.at(case.measured.time)
    noise = floors.noise[number]
    values = {s: _sensed(np.asarray(getattr(trace, s)), case, s, noise[s], random) for s in problem.signals(number)}
    played = replace(case, measured=_measured(case.measured, values), noise=dict(case.noise))
    return cut(played, case.length) if case.windows else played


def physics_at(physics: PhysicsSpec, rate: float) -> PhysicsSpec:
    """The same physics at another step rate [Hz]."""
    return physics.model_copy(update={"step_rate": rate})


def _sensed(value: Array, case: Case, signal: str, noise: Array, random: np.random.Generator) -> Array:
    """What the scenario's own sensor would have said: its noise, its quantum, and its gaps."""
    step = quantum(case.value(signal)) if case.repetitions == 1 else np.zeros(value.shape[1])
    beside = np.sqrt(np.maximum(noise**2 - step**2 / 12, 0.0))  # rounding is noise, too
    out = value + beside * random.standard_normal(value.shape)
    out = np.where(step > 0, np.round(out / np.where(step > 0, step, 1.0)) * step, out)
    if signal == "base_quaternion":
        out = out / np.linalg.norm(out, axis=1, keepdims=True)
    return np.asarray(np.where(np.isnan(case.value(signal)), np.nan, out))


def _measured(trace: Trace, values: dict[str, Array]) -> Trace:
    return replace(
        trace,
        position=values.get("position", trace.position),
        velocity=values.get("velocity", trace.velocity),
        effort=values.get("effort", trace.effort),
        base_position=values.get("base_position", trace.base_position),
        base_quaternion=values.get("base_quaternion", trace.base_quaternion),
    )
