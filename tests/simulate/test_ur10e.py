"""The UR10e with a known load: what the committed scenarios say of it, and what is left is the load."""

from pathlib import Path

import numpy as np
import pytest
from realitygap.scenario.file import load_scenario
from realitygap.simulate.experiment import experiments, simulate

SCENARIO = Path(__file__).parents[2] / "scenarios" / "ur10e" / "loaded.yaml"
MASS = 2.805


def test_the_load_is_what_the_loaded_run_lacks(data_dir: Path) -> None:
    """By Gauss and Newton on a payload at the last link, joints weighed by what is left of them: within 5 %."""
    if not (data_dir / "ur10e").is_dir():
        pytest.skip("needs the recordings of the UR10e")
    (loaded,) = experiments(load_scenario(SCENARIO))
    assert loaded.recording is not None
    measured = loaded.recording.trace.effort
    assert measured is not None
    last = [link.name for link in loaded.plant.model.links].index("wrist_3_link")

    def rest(load: np.ndarray) -> np.ndarray:
        plant = loaded.plant.copy()
        plant.payloads[last] = tuple(load)
        found = simulate(loaded.with_plant(plant), "mujoco").trace.effort
        assert found is not None
        return np.asarray(measured - found)

    load, weight = np.array([1.0, 0.0, 0.1, 0.0]), np.ones(measured.shape[1])
    for _ in range(8):
        here = rest(load)
        weight = 1 / here.std(axis=0)
        slope = np.array([(here - rest(load + 1e-3 * d)) / 1e-3 for d in np.eye(4)])
        load = load + np.linalg.lstsq((slope * weight).reshape(4, -1).T, (here * weight).ravel(), rcond=None)[0]
    assert load[0] == pytest.approx(MASS, rel=0.05)
    assert np.linalg.norm(load[1:]) < 0.3
