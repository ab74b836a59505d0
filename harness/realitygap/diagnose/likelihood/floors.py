"""The floors of every sample: noise, disturbances and numerics, for the model as it stands."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from realitygap_engines import Diverged, Unsupported

from realitygap.diagnose.data.case import TINY
from realitygap.diagnose.data.pool import Pool
from realitygap.diagnose.data.problem import Change, Problem
from realitygap.diagnose.likelihood.disturbance import Moved, disturbances, sensitivity, spread
from realitygap.robot.drive import Array

COARSE = (0.25, 0.5)
"""Where only the change of the traces counts, the least of these shares of the step rate is enough ..."""
FAITHFUL = 0.3
"""... that moves the traces by no more than this, in standard deviations (rms)."""


def set_floors(pool: Pool, changes: Sequence[Change]) -> Array:
    """Measure the floors of every case with a changed plant, and keep them in the problem; then how coarse a step is
    enough beside them.

    Returns:
        The disturbing torque on each joint in one repetition [N·m], shape (n,).
    """
    problem = pool.problem
    each = [(tuple(changes), i) for i in range(len(problem.cases))]
    answers = pool.map(_floors, each)
    torque = disturbances(problem, [moved for _, moved in answers])
    for case, (floor, moved) in zip(problem.cases, answers, strict=True):
        case.floor, case.disturbed = floor, spread(case, moved, torque)
    _set_noise(problem, bool(torque.any()))
    pool.renew()
    for case, share in zip(problem.cases, pool.map(_coarse, each), strict=True):
        case.coarse = share
    pool.renew()
    return torque


def _floors(problem: Problem, changes: tuple[Change, ...], case: int) -> tuple[dict[str, Array], Moved]:
    try:
        floor = problem.numerical_floor(changes, case)
    except (Diverged, Unsupported):
        floor = {}
    return floor, sensitivity(problem, changes, case)


def _coarse(problem: Problem, changes: tuple[Change, ...], case: int) -> float:
    """The least share of the step rate that hardly moves the traces."""
    full = problem.residuals(changes, case)
    for share in COARSE:
        if np.sqrt(np.mean((problem.residuals(changes, case, finer=share) - full) ** 2)) <= FAITHFUL:
            return share
    return 1.0


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
