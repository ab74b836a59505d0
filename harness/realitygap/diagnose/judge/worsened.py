"""What came out further from the measurement than before."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from realitygap.compare.gap import unit_of
from realitygap.diagnose.data.case import JOINT_SIGNALS
from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.likelihood.floors import Floors
from realitygap.robot.drive import Array

SEEN = 1.05
"""A gap that grows less is the same ..."""
ABOVE = 0.25
"""... and so is one that grows by less than this part of the noise floor."""

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


def worsened(
    problem: Problem, floors: Floors, judge: Sequence[int], before: Simulations, after: Simulations
) -> list[Worsened]:
    """Joints and signals whose mean gap on held-out motions grew by a twentieth and a quarter of the noise."""
    out = []
    for j, joint in enumerate(problem.plant.model.joints):
        for signal in JOINT_SIGNALS:
            cases = _compared(problem, signal, judge, before, after)
            if not cases or not problem.judged[j] or not problem.measured(cases, signal, j):
                continue
            unit, scale = unit_of(signal, joint.prismatic)
            was, now = (_gap(problem, cases, signal, j, simulated) for simulated in (before, after))
            noise = float(np.mean([floors.noise[i][signal][j] for i in cases]))
            if now > was * SEEN and now - was > ABOVE * noise:
                out.append(Worsened(joint.name, signal, unit, was * scale, now * scale))
    return out


def _compared(
    problem: Problem, signal: str, judge: Sequence[int], before: Simulations, after: Simulations
) -> list[int]:
    """The cases in which a signal was measured and simulated both times."""
    return [i for i in judge if i in before and i in after and signal in problem.signals(i)]


def _gap(problem: Problem, cases: Sequence[int], signal: str, joint: int, simulated: Simulations) -> float:
    parts = [np.abs(simulated[i][signal][:, joint] - problem.cases[i].value(signal)[:, joint]) for i in cases]
    return float(np.nanmean(np.concatenate(parts)))


@dataclass(frozen=True)
class InUnits:
    """The mean absolute gap of a signal over judged joints and held-out motions, before and after, in `unit`."""

    signal: str
    unit: str
    before: float
    after: float

    @property
    def logarithm(self) -> float:
        """Of how many times as large the gap is after; 0 where nothing moved."""
        return float(np.log(self.after / self.before)) if self.after > 0.0 < self.before else 0.0


def in_units(problem: Problem, judge: Sequence[int], before: Simulations, after: Simulations) -> list[InUnits]:
    """The gaps of joints in units, by signal and kind of joint: floors change with the model, units do not."""
    out = []
    for signal in JOINT_SIGNALS:
        cases = _compared(problem, signal, judge, before, after)
        for prismatic in (False, True) if cases else ():
            joints = [
                j
                for j, t in enumerate(problem.plant.model.joints)
                if t.prismatic == prismatic and problem.judged[j] and problem.measured(cases, signal, j)
            ]
            if joints:
                unit, scale = unit_of(signal, prismatic)
                was, now = (
                    float(np.mean([_gap(problem, cases, signal, j, sim) for j in joints])) * scale
                    for sim in (before, after)
                )
                if was or now:  # of a joint that nobody drives both efforts are none
                    out.append(InUnits(signal, unit, was, now))
    return out
