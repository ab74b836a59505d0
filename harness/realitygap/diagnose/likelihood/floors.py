"""The floors of every sample: the sensors' noise, disturbances and numerics, for a model as it stands."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from realitygap.diagnose.data.case import TINY, Case
from realitygap.diagnose.data.changes import Change
from realitygap.diagnose.data.noise import local_maximum
from realitygap.diagnose.data.problem import Problem, Signals
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.data.worker import Query
from realitygap.diagnose.likelihood.disturbance import disturbances, sensitivities, spread
from realitygap.diagnose.likelihood.initial_state import initial_state_spread
from realitygap.robot.drive import Array

COARSE = (0.25, 0.5)
"""Where only the change of the traces counts, the least of these shares of the step rate is enough ..."""
FAITHFUL = 0.3
"""... that moves the traces by no more than this, in floors (rms): it adds 5 % to what noise and floors make."""
NEIGHBOURS = 3
"""Samples around a step transient that share its numerical floor."""


@dataclass(frozen=True)
class Floors:
    """How far samples may be off without meaning anything, by case and signal.

    Attributes:
        noise: standard deviation of the sensor per joint, independent from sample to sample. Shape (n,).
        slow: standard deviation of what lasts: numerics, disturbances, where windows begin. Shape (t, n).
        coarse: the share of the step rate that is enough where only the change of the traces counts.
        torque: the disturbing torque on each joint in one repetition [N·m]. Shape (n,).
    """

    noise: tuple[dict[str, Array], ...]
    slow: tuple[dict[str, Array], ...]
    coarse: tuple[float, ...]
    torque: Array

    def sigma(self, case: int, signal: str) -> Array:
        """The floor of each sample. Shape (t, n)."""
        return np.asarray(np.hypot(self.noise[case][signal], self.slow[case][signal]))


def measure(simulations: Simulations, changes: Sequence[Change], cases: Sequence[int] | None = None) -> Floors:
    """The floors of cases for a model with changes, and how coarse a step is enough beside them.

    Of other cases than those that are asked for, which are all by default, the sensors' noise alone is told.
    """
    problem = simulations.problem
    cases = range(len(problem.cases)) if cases is None else cases
    numerical = _numerical(simulations, changes, cases)
    moved = sensitivities(simulations, changes, cases)
    torque = disturbances(problem, moved)
    begun = initial_state_spread(simulations, changes, cases)
    disturbed = [spread(c, m, torque) for c, m in zip(problem.cases, moved, strict=True)]
    noise = _noise(problem, disturbed, cases, bool(torque.any()))
    slow = []
    for case, *parts in zip(problem.cases, numerical, disturbed, begun, strict=True):
        none = {s: np.zeros_like(case.value(s)) for s in case.noise}
        slow.append({s: np.sqrt(sum(part.get(s, none[s]) ** 2 for part in parts)) for s in case.noise})
    fine = Floors(noise, tuple(slow), (1.0,) * len(problem.cases), torque)
    return Floors(noise, fine.slow, _coarse(simulations, changes, fine, cases), torque)


def _numerical(simulations: Simulations, changes: Sequence[Change], cases: Sequence[int]) -> list[dict[str, Array]]:
    """How far half the step moves each sample: the largest among neighbours, doubled. Shape (t, n).

    Of a motion that is followed it is the standard error of the effort, as far as accelerations are known.

    A held command moves the effort at once, and which side of the jump a sample saw is not known: it is part of it.
    """
    problem = simulations.problem
    out: list[dict[str, Array]] = [{} for _ in problem.cases]
    asked = [Query(tuple(changes), c, problem.engine, finer, jumps=finer == 1.0) for c in cases for finer in (1.0, 2.0)]
    answers = simulations.ask(asked)
    for k, i in enumerate(cases):
        case, (coarse, fine) = problem.cases[i], answers[2 * k : 2 * k + 2]
        floor: dict[str, Array] = {}
        if coarse is not None and fine is not None:
            moved = {s: np.abs(coarse[s] - fine[s]) for s in case.noise}
            followed = case.experiment.followed is not None
            floor = moved if followed else {s: 2.0 * local_maximum(m, NEIGHBOURS) for s, m in moved.items()}
            if "effort" in floor and case.experiment.commands.held:
                floor["effort"] = np.hypot(floor["effort"], coarse["jump"])
        out[i] = floor
    return out


def _coarse(
    simulations: Simulations, changes: Sequence[Change], floors: Floors, cases: Sequence[int]
) -> tuple[float, ...]:
    """The least share of the step rate that hardly moves the traces, by case."""
    problem = simulations.problem
    full, *less = (
        simulations.ask([Query(tuple(changes), c, problem.engine, share) for c in cases]) for share in (1.0, *COARSE)
    )
    out = [1.0] * len(problem.cases)
    for k, c in enumerate(cases):
        for share, answers in zip(COARSE, less, strict=True):
            a, b = full[k], answers[k]
            if a is not None and b is not None and _apart(problem, floors, c, a, b) <= FAITHFUL:
                out[c] = min(out[c], share)
    return tuple(out)


def _apart(problem: Problem, floors: Floors, case: int, a: Signals, b: Signals) -> float:
    squares = [
        (problem.difference(s, a[s], b[s]) / problem.deviation(s, floors.sigma(case, s))).ravel() ** 2
        for s in problem.signals(case)
    ]
    return float(np.sqrt(np.mean(np.concatenate(squares))))


def _noise(
    problem: Problem, disturbed: Sequence[dict[str, Array]], cases: Sequence[int], modelled: bool
) -> tuple[dict[str, Array], ...]:
    """The noise of every case beside what disturbances explain of the spread between repetitions of `cases`."""
    out = [dict(c.noise) for c in problem.cases]
    for signal in {s for c in problem.cases for s in c.noise}:
        repeated = [(problem.cases[i], disturbed[i]) for i in cases if signal in problem.cases[i].spread]
        if not repeated:
            continue
        seen = np.mean([c.spread[signal] ** 2 for c, _ in repeated], axis=0)
        single = np.sqrt(seen)
        if modelled:
            white = np.mean([c.white[signal] ** 2 for c, _ in repeated], axis=0)
            pushed = np.mean([_pushed(c, d.get(signal), seen) for c, d in repeated], axis=0)
            single = np.sqrt(np.maximum(white, seen - pushed))
        single = np.where(seen > 0, single, repeated[0][0].white[signal])
        for case, noise in zip(problem.cases, out, strict=True):
            if signal in noise:
                noise[signal] = np.maximum(single / np.sqrt(case.repetitions), TINY[signal])
    return tuple(out)


def _pushed(case: Case, disturbed: Array | None, seen: Array) -> Array:
    return np.zeros_like(seen) if disturbed is None else np.mean(disturbed**2, axis=0) * case.repetitions
