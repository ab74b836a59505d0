"""Velocity filters that recordings show by themselves, planted in the bundled demo (synthetic)."""

from dataclasses import replace

import numpy as np
import pytest
from realitygap.diagnose.candidates.suspects import suspects
from realitygap.diagnose.candidates.told import deviations, velocity_filters
from realitygap.diagnose.data.problem import Problem
from realitygap.recording.faults import low_pass

Z95 = 1.96


@pytest.mark.parametrize("scale", [0.8, 1.25])
@pytest.mark.parametrize("time", [0.0131, 0.0274])
def test_a_filter_is_seen_and_its_interval_holds_it(problem: Problem, scale: float, time: float) -> None:
    cases = []
    for case in problem.cases:
        period = float(np.median(np.diff(case.measured.time)))
        travel = np.asarray(np.gradient(case.value("position"), case.measured.time, axis=0))
        slow = np.column_stack([scale * low_pass(travel[:, j], time, period) for j in range(travel.shape[1])])
        cases.append(replace(case, measured=replace(case.measured, velocity=slow)))
    planted = replace(problem, cases=tuple(cases))
    (found,) = velocity_filters(planted, suspects(planted))
    off = deviations(planted, found)
    for name, true in (("scale", scale), ("time", time)):
        assert abs(found.parameters[name] - true) < Z95 * off[name]
        assert Z95 * off[name] < 0.02 * true
