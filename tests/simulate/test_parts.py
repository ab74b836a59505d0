"""A motion that is simulated stretch after stretch is the motion that is simulated at once."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import realitygap_engines as engines
from numpy.testing import assert_array_equal
from realitygap.robot.plant import Plant
from realitygap.scenario.file import load_scenario
from realitygap.simulate import experiment
from realitygap.simulate.commands import Commands, on_steps
from realitygap.simulate.experiment import Experiment, experiments, simulate
from realitygap.trace.trace import Trace

DEMO = Path(__file__).parents[2] / "scenarios" / "demo" / "scenario.yaml"
SECONDS = 0.5


@pytest.fixture(scope="module")
def case() -> Experiment:
    found = experiments(load_scenario(DEMO), only=["chirp_1"])[0]
    return replace(found, duration=SECONDS)


def changed(case: Experiment, **values: Any) -> Experiment:
    """The experiment with drives and sensors that remember what was."""
    drive = case.plant.drive.copy()
    plant: Plant = replace(case.plant, drive=drive, **values)
    return case.with_plant(plant)


@pytest.mark.parametrize("engine", engines.available())
@pytest.mark.parametrize("most", [2, 77, 10_000])
def test_parts_are_the_whole(engine: str, most: int, case: Experiment, monkeypatch: pytest.MonkeyPatch) -> None:
    n = len(case.plant.model.joints)
    slow = changed(case, velocity_lag=np.full(n, 0.02), delay=np.linspace(0.0, 0.013, n))
    whole = simulate(slow, engine)
    times = np.sort(np.random.default_rng(1).uniform(-0.1, SECONDS + 0.1, 300))
    times = np.unique(np.concatenate([times, whole.trace.time[::50]]))
    monkeypatch.setattr(experiment, "PART", most)
    parts = simulate(slow, engine, at=times)
    assert parts.steps == whole.steps
    assert parts.trace.command is None
    wanted = whole.trace.at(times)
    for signal in (s for s in Trace.SIGNALS if s != "command"):
        ours, theirs = getattr(parts.trace, signal), getattr(wanted, signal)
        assert (ours is None) == (theirs is None)
        if ours is not None:
            np.testing.assert_allclose(ours, theirs, rtol=1e-9, atol=1e-11, err_msg=signal)


@pytest.mark.parametrize("held", [True, False])
def test_commands_of_a_stretch_are_those_of_the_whole(held: bool) -> None:
    random = np.random.default_rng(2)
    value = random.normal(size=(400, 2))
    value[100:130, 1] = np.nan
    commands = Commands(np.sort(random.uniform(-0.1, 2.0, 400)), value, held)
    delay = np.array([0.0, 0.03])
    whole = on_steps(commands, 2000, 1e-3, delay)
    for first, steps in ((0, 2000), (1, 10), (700, 300), (1990, 10)):
        part = on_steps(commands, steps, 1e-3, delay, first)
        np.testing.assert_allclose(part, whole[first : first + steps], rtol=1e-9, atol=1e-9)
        assert_array_equal(np.isnan(part), np.isnan(whole[first : first + steps]))
