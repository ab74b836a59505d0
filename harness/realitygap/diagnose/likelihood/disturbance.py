"""Disturbances: torques that differ from one repetition to the next, and how far they move each sample.

What repetitions differ by is not the same everywhere: a servo that is off lets the smallest torque move the joint far.
The spread seen in repeated motions is therefore turned into a torque, and that torque into a spread of every sample.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from realitygap.diagnose.data.case import Case
from realitygap.diagnose.data.changes import Change
from realitygap.diagnose.data.noise import local_maximum
from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.data.push import Push
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.data.worker import Query
from realitygap.robot.drive import Array

MANY = 6
"""With more joints than this, the spread of repetitions is taken as it is: every joint would cost four simulations."""
LIKELY = 2.0
"""The spread of a few repetitions may be this many times smaller than that of many: the 5 % quantile of the standard
deviation of two or three samples is 0.06 to 0.23 of the true one, of five 0.42."""
RANDOM = 3
"""Random torques that are tried beside a constant one: a free joint swings up under what comes and goes, a stiff one
leans under what stays."""
ENVELOPE = 0.05
"""A swing is as uncertain where it crosses its mean as at its ends: the largest within this time counts [s]."""
PUSH = 0.01
"""The torque that is tried, as a share of what the servo can give: small enough for a straight line."""

Moved = dict[int, dict[str, Array]]
"""How far each sample of a motion moves per N·m on a joint: by joint and signal, shape (t, n)."""


def sensitivities(simulations: Simulations, changes: Sequence[Change], cases: Sequence[int]) -> list[Moved]:
    """The sensitivity of each sample of cases to a disturbing torque on each joint, per N·m, in root mean square.

    Empty for other cases, and where no motion was repeated, the joints are many, or a simulation failed.
    """
    problem = simulations.problem
    n = len(problem.plant.model.joints)
    if n > MANY or not problem.repeated:
        return [{} for _ in problem.cases]
    push = [PUSH * _scale(problem.plant.drive["effort_limit"][j], problem.plant.drive[j]) for j in range(n)]
    tries = [Push(j, push[j], seed) for j in range(n) for seed in (None, *range(RANDOM))]
    asked = [Query(tuple(changes), c, problem.engine, push=p) for c in cases for p in (None, *tries)]
    answers = simulations.ask(asked)
    size = 1 + len(tries)
    out: list[Moved] = [{} for _ in problem.cases]
    for k, c in enumerate(cases):
        out[c] = _moved(problem, c, tries, answers[k * size : (k + 1) * size])
    return out


def _moved(problem: Problem, case: int, tries: Sequence[Push], answers: Sequence[dict[str, Array] | None]) -> Moved:
    still, *pushed = answers
    time = problem.cases[case].measured.time
    near = max(int(ENVELOPE * (len(time) - 1) / (time[-1] - time[0])), 1)
    out: Moved = {}
    if still is None or any(p is None for p in pushed):
        return out
    for j in sorted({p.joint for p in tries}):
        of = [(p, a) for p, a in zip(tries, pushed, strict=True) if p.joint == j and a is not None]
        out[j] = {
            s: local_maximum(np.sqrt(np.mean([((a[s] - still[s]) / p.torque) ** 2 for p, a in of], axis=0)), near)
            for s in problem.joint_signals(case)
        }
    return out


def _scale(limit: float, drive: np.void) -> float:
    """About what torque the servo can give [N·m or N]."""
    stall = drive["torque_constant"] * max(drive["supply"], 1.0) / drive["resistance"]
    candidates = [x for x in (limit, stall) if np.isfinite(x) and x > 0]
    return float(min(candidates, default=1.0))


def disturbances(problem: Problem, moved: Sequence[Moved]) -> Array:
    """The disturbing torque on each joint [N·m] that explains how repetitions differ. Shape (n,); 0 where none were.

    Args:
        problem: whose motions were repeated.
        moved: how far a torque moves each of them.
    """
    n = len(problem.plant.model.joints)
    repeated = [i for i, c in enumerate(problem.cases) if c.repetitions > 1 and "position" in c.noise and moved[i]]
    ratios = np.zeros((len(repeated), n))
    for row, i in enumerate(repeated):
        c = problem.cases[i]
        excess = np.maximum(c.spread["position"] ** 2 - c.white["position"] ** 2, 0.0)
        for j, signals in moved[i].items():
            ratios[row, j] = np.sqrt(excess[j] / max(float(np.mean(signals["position"][:, j] ** 2)), 1e-30))
    return np.asarray(ratios.mean(axis=0)) if repeated else np.zeros(n)


def spread(case: Case, moved: Moved, torque: Array) -> dict[str, Array]:
    """The spread of every sample under disturbing torques (n,), of the mean of its repetitions. Shape (t, n).

    Of a motion that was itself repeated it is at most `LIKELY` times what was seen: a model that lacks friction swings
    farther than the robot where a servo is off, and would make the samples that show it worthless.
    """
    out = dict[str, Array]()
    for j, signals in moved.items():
        for signal, far in signals.items():
            if torque[j] > 0:
                out[signal] = np.hypot(out.get(signal, 0.0), torque[j] * far)
    if case.repetitions > 1:
        for signal, value in out.items():
            size = np.sqrt(np.mean(value**2, axis=0))
            out[signal] = value * np.minimum(1.0, LIKELY * case.spread[signal] / np.maximum(size, 1e-30))
    return {signal: value / np.sqrt(case.repetitions) for signal, value in out.items()}
