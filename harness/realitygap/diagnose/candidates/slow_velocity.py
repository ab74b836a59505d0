"""Velocities that are no derivatives: scaled or low-passed before they are reported."""

from __future__ import annotations

import numpy as np

from realitygap.diagnose.candidates.runs import Seen
from realitygap.diagnose.data.problem import Problem
from realitygap.recording.faults import SURE, at_fault, velocity_of_position


def slow_velocity(problem: Problem, joint: int) -> list[Seen]:
    """Scale and time constant [s] of a joint's reported velocity, of every run that can tell."""
    out = []
    for c, case in enumerate(problem.cases):
        if "velocity" not in problem.signals(c):
            continue
        time = case.measured.time
        fit = velocity_of_position(time, case.value("position")[:, joint], case.value("velocity")[:, joint])
        if fit is not None and abs(fit[2]) > SURE:
            out.append(Seen(fit[:2], at_fault(*fit, float(np.median(np.diff(time))))))
    return out
