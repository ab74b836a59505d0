"""What came out further from the measurement than before."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from realitygap.compare.gap import unit_of
from realitygap.diagnose.data.case import JOINT_SIGNALS
from realitygap.diagnose.data.problem import Problem
from realitygap.robot.drive import Array

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
    for j, joint in enumerate(problem.plant.model.joints):
        for signal in JOINT_SIGNALS:
            cases = _compared(problem, signal, judge, before, after)
            if not cases or not problem.judged[j]:
                continue
            unit, scale = unit_of(signal, joint.prismatic)
            was, now = (_gap(problem, cases, signal, j, simulated) for simulated in (before, after))
            noise = float(np.mean([problem.cases[i].noise[signal][j] for i in cases]))
            if now > was * SEEN and now - was > ABOVE * noise:
                out.append(Worsened(joint.name, signal, unit, was * scale, now * scale))
    return out


def hurt(problem: Problem, judge: Sequence[int], before: Simulations, after: Simulations) -> list[str]:
    """The signals that came out far worse over all joints and held-out motions, in floors."""
    out = []
    for signal in JOINT_SIGNALS:
        cases = _compared(problem, signal, judge, before, after)
        if cases:
            was, now = (_mean_square(problem, cases, signal, simulated) for simulated in (before, after))
            if now > HURT**2 * was and now - was > 1.0:
                out.append(signal)
    return out


def _compared(
    problem: Problem, signal: str, judge: Sequence[int], before: Simulations, after: Simulations
) -> list[int]:
    """The cases in which a signal was measured and simulated both times."""
    return [i for i in judge if i in before and i in after and signal in problem.signals(i)]


def _mean_square(problem: Problem, cases: Sequence[int], signal: str, simulated: Simulations) -> float:
    return float(np.mean([np.nanmean(problem.scaled(i, signal, simulated[i]) ** 2) for i in cases]))


def _gap(problem: Problem, cases: Sequence[int], signal: str, joint: int, simulated: Simulations) -> float:
    parts = [np.abs(simulated[i][signal][:, joint] - problem.cases[i].value(signal)[:, joint]) for i in cases]
    return float(np.nanmean(np.concatenate(parts)))
