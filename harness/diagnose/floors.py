"""The floors of every sample: noise, disturbances and numerics, for the model as it stands."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from engines import Diverged, Unsupported
from harness.diagnose.case import TINY
from harness.diagnose.disturbance import disturbances, spread
from harness.diagnose.pool import Pool
from harness.diagnose.problem import Change, Problem
from harness.drive import Array


def set_floors(pool: Pool, changes: Sequence[Change]) -> None:
    """Measure the floors of every case with a changed plant, and keep them in the problem."""
    problem = pool.problem
    torque = disturbances(problem, changes)
    answers = pool.map(_floors, [(tuple(changes), i, torque) for i in range(len(problem.cases))])
    for case, (floor, disturbed) in zip(problem.cases, answers, strict=True):
        case.floor, case.disturbed = floor, disturbed
    _set_noise(problem, bool(torque.any()))
    pool.renew()


def _floors(
    problem: Problem, changes: tuple[Change, ...], case: int, torque: Array
) -> tuple[dict[str, Array], dict[str, Array]]:
    try:
        floor = problem.numerical_floor(changes, case)
    except (Diverged, Unsupported):
        floor = {}
    return floor, spread(problem, changes, case, torque)


def _set_noise(problem: Problem, modelled: bool) -> None:
    """The noise of every case beside what disturbances explain of the spread between repetitions."""
    for signal in {s for c in problem.cases for s in c.noise}:
        repeated = [c for c in problem.cases if signal in c.spread]
        if not repeated:
            continue
        seen = np.mean([c.spread[signal] ** 2 for c in repeated], axis=0)
        if modelled:
            white = np.mean([c.white[signal] ** 2 for c in repeated], axis=0)
            pushed = np.mean([_pushed(c.disturbed.get(signal), c.repetitions, seen) for c in repeated], axis=0)
            single = np.sqrt(np.maximum(white, seen - pushed))
        else:
            single = np.sqrt(seen)
        single = np.where(seen > 0, single, repeated[0].white[signal])
        for c in problem.cases:
            if signal in c.noise:
                c.noise[signal] = np.maximum(single / np.sqrt(c.repetitions), TINY[signal])


def _pushed(disturbed: Array | None, repetitions: int, seen: Array) -> Array:
    return np.zeros_like(seen) if disturbed is None else np.mean(disturbed**2, axis=0) * repetitions
