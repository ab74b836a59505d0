"""A thrown body flies along its parabola whatever the step: gravity acts from its first position on."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import realitygap_engines as engines
from numpy.testing import assert_allclose
from realitygap.scenario.file import load_scenario
from realitygap.simulate.experiment import Experiment, experiments, simulate
from synthetic_tosses import COLUMNS, CUBE

HIGH, UP, ALONG = 2.0, 1.0, 0.7
"""Where it is thrown from [m], and how fast [m/s]."""
SCENARIO = """
name: toss
robot: {urdf: cube.urdf, base: free}
ground: flat
physics: {step_rate: 500}
recordings: {runs: [{path: toss.csv}]}
"""


@pytest.fixture
def toss(tmp_path: Path) -> Experiment:
    (tmp_path / "cube.urdf").write_text(CUBE)
    time = np.arange(0.0, 0.5, 1 / 150)
    base = np.zeros((len(time), len(COLUMNS)))
    base[:, 0], base[:, 2], base[:, 3] = ALONG * time, HIGH + UP * time - 0.5 * 9.81 * time**2, 1.0
    base[:, 7], base[:, 9] = ALONG, UP - 9.81 * time
    frame = pd.DataFrame(np.column_stack([time, base]), columns=["time", *COLUMNS])
    frame.to_csv(tmp_path / "toss.csv", index=False)
    (tmp_path / "scenario.yaml").write_text(SCENARIO)
    return experiments(load_scenario(tmp_path / "scenario.yaml"))[0]


@pytest.mark.parametrize("engine", engines.available())
@pytest.mark.parametrize("times", [1, 2, 4])
def test_a_flight_does_not_hang_on_the_step(toss: Experiment, engine: str, times: int) -> None:
    trace = simulate(toss, engine, step_rate=500.0 * times).trace
    assert trace.base_position is not None
    flight = trace.time - trace.time[0]
    assert_allclose(trace.base_position[:, 2], HIGH + UP * flight - 0.5 * 9.81 * flight**2, atol=2e-5)
    assert_allclose(trace.base_position[:, 0], ALONG * flight, atol=2e-5)
