"""What a diagnosis works on, on the bundled demo (synthetic)."""

from dataclasses import replace
from pathlib import Path

import numpy as np
from realitygap.compare.comparison import motions_of
from realitygap.diagnose.data.case import cases_of
from realitygap.diagnose.data.problem import reached
from realitygap.scenario.file import load_scenario

DEMO = Path(__file__).parents[2] / "scenarios" / "demo" / "scenario.yaml"


def test_a_joint_that_was_never_recorded_reached_no_speed() -> None:
    case = cases_of(motions_of(load_scenario(DEMO)))[0]
    t = case.measured.time
    nothing = np.full((len(t), 1), np.nan)
    position = np.column_stack([-2.5 * t, nothing])
    both = replace(
        case.measured, joints=("elbow", "wrist"), position=position, velocity=None, effort=None, command=None
    )
    assert np.allclose(reached([replace(case, measured=both)]), [2.5, 0.0])
