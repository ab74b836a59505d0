"""Disturbances: torques that differ from one repetition to the next, and how far they move each sample.

What repetitions differ by is not the same everywhere: a servo that is off lets the smallest torque move the joint far.
The spread seen in repeated motions is therefore turned into a torque, and that torque into a spread of every sample.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from realitygap_engines import Diverged, Unsupported
from scipy.signal import lfilter

from realitygap.diagnose.data.case import Case
from realitygap.diagnose.data.noise import local_maximum
from realitygap.diagnose.data.problem import Change, Problem
from realitygap.robot.drive import Array
from realitygap.robot.plant import Plant
from realitygap.simulate.experiment import Experiment, simulate

MANY = 6
"""With more joints than this, the spread of repetitions is taken as it is."""
LIKELY = 2.0
"""The spread of a few repetitions may be this many times smaller than that of many."""

Moved = dict[int, dict[str, Array]]
"""How far each sample of a motion moves per N·m on a joint: by joint and signal, shape (t, n)."""


def sensitivity(problem: Problem, changes: Sequence[Change], case: int) -> Moved:
    """How far each sample moves per N·m of a disturbing torque on each joint.

    The root mean square over a constant torque and some random ones: a free joint swings up under what comes and goes,
    a stiff one leans under what stays. Empty where no motion was repeated, or the joints are many.
    """
    n = len(problem.plant.model.joints)
    if n > MANY or not problem.repeated:
        return {}
    c, plant = problem.cases[case], problem.changed_plant(changes, case)

    def simulated(pushed: Plant) -> dict[str, Array]:
        trace = simulate(c.experiment.with_plant(pushed), problem.engine).trace.at(c.measured.time)
        return {s: np.asarray(getattr(trace, s)) for s in problem.joint_signals(case)}

    rate = (len(c.measured.time) - 1) / (c.measured.time[-1] - c.measured.time[0])
    near = max(int(ENVELOPE * rate), 1)
    out: Moved = {}
    try:
        still = simulated(plant)
        for j in range(n):
            push = 0.01 * _scale(plant.drive["effort_limit"][j], plant.drive[j])
            moved = [simulated(p) for p in _pushed(plant, j, push, c.experiment)]
            squares = {s: np.mean([(m[s] - still[s]) ** 2 for m in moved], axis=0) for s in still}
            out[j] = {s: local_maximum(np.sqrt(square), near) / push for s, square in squares.items()}
    except (Diverged, Unsupported):
        return {}
    return out


def _pushed(plant: Plant, joint: int, push: float, experiment: Experiment) -> list[Plant]:
    """The plant under a constant torque on a joint and under some random ones of the same size."""
    plants = [plant.copy() for _ in range(RANDOM + 1)]
    plants[0].drive["constant"][joint] += push
    h = experiment.scenario.timestep
    steps = int(experiment.duration / h) + 3
    for k, pushed in enumerate(plants[1:]):
        pushed.efforts.append(Push(coloured(steps, h, k) * push, h, joint, len(plant.model.joints)))
    return plants


RANDOM = 3
"""Random torques that are tried."""
CORRELATION = 0.15
"""Their correlation time [s]."""
ENVELOPE = 0.05
"""A swing is as uncertain where it crosses its mean as at its ends: the largest within this time counts [s]."""


@dataclass(frozen=True)
class Push:
    """A torque on one joint over time, as a joint effort of a plant."""

    torque: Array
    h: float
    joint: int
    count: int

    def __call__(self, t: float, _q: Array, _w: Array) -> Array:
        out = np.zeros(self.count)
        out[self.joint] = self.torque[min(round(t / self.h), len(self.torque) - 1)]
        return out


def coloured(steps: int, h: float, seed: int) -> Array:
    """Random numbers of unit variance and a correlation time, the same for the same seed. Shape (steps,)."""
    keep = np.exp(-h / CORRELATION)
    white = np.random.default_rng(seed).standard_normal(steps) * np.sqrt(1 - keep**2)
    return np.asarray(lfilter([1.0], [1.0, -keep], white))


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
    repeated = [i for i, c in enumerate(problem.cases) if c.repetitions > 1 and "position" in c.noise]
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
