"""What came out further from the measurement than before."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from harness.diagnose.case import JOINT_SIGNALS
from harness.diagnose.problem import Problem
from harness.drive import Array
from harness.gap import unit_of

SEEN = 1.05
"""A gap that grows less is the same ..."""
ABOVE = 0.25
"""... and so is one that grows by less than this part of the noise floor."""

HURT = 1.25
"""A signal whose gap grows this many times, and by more than the floor, is hurt."""

Simulations = Mapping[int, Mapping[str, Array]]
"""Simulated signals by case."""


@dataclass
class Worsened:
    """A joint and signal that came out further from the measurement than before, on held-out motions.

    `before` and `after` are mean absolute gaps in `unit`.
    """

    joint: str
    signal: str
    unit: str
    before: float
    after: float


def worsened(problem: Problem, judge: Sequence[int], before: Simulations, after: Simulations) -> list[Worsened]:
    """Joints and signals whose mean gap on held-out motions grew by more than the noise floor."""
    out = []
    cases = [i for i in judge if i in before and i in after]
    for j, joint in enumerate(problem.plant.model.joints):
        for signal in JOINT_SIGNALS:
            with_signal = [i for i in cases if signal in problem.signals(i)]
            if not with_signal or not problem.judged[j]:
                continue
            unit, scale = unit_of(signal, joint.prismatic)
            was, now = (_gap(problem, with_signal, signal, j, simulated) for simulated in (before, after))
            noise = float(np.mean([problem.cases[i].noise[signal][j] for i in with_signal]))
            if now > was * SEEN and now - was > ABOVE * noise:
                out.append(Worsened(joint.name, signal, unit, was * scale, now * scale))
    return out


def hurt(problem: Problem, judge: Sequence[int], before: Simulations, after: Simulations) -> list[str]:
    """The signals that came out far worse over all joints and held-out motions, in floors."""
    cases = [i for i in judge if i in before and i in after]
    out = []
    for signal in JOINT_SIGNALS:
        with_signal = [i for i in cases if signal in problem.signals(i)]
        if with_signal:
            was, now = (_mean_square(problem, with_signal, signal, simulated) for simulated in (before, after))
            if now > HURT**2 * was and now - was > 1.0:
                out.append(signal)
    return out


def _mean_square(problem: Problem, cases: Sequence[int], signal: str, simulated: Simulations) -> float:
    parts = []
    for i in cases:
        case = problem.cases[i]
        delta = (simulated[i][signal] - case.value(signal)) / case.sigma(signal)
        parts.append(np.nanmean(delta[:, problem.judged] ** 2))
    return float(np.mean(parts))


def _gap(problem: Problem, cases: Sequence[int], signal: str, joint: int, simulated: Simulations) -> float:
    parts = [np.abs(simulated[i][signal][:, joint] - problem.cases[i].value(signal)[:, joint]) for i in cases]
    return float(np.nanmean(np.concatenate(parts)))
