"""Commands that a first scenario takes for samples of a trajectory, and those that it holds."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from first_scenario import arm, goal, read_all
from realitygap.init.draft import Draft, init
from realitygap.scenario.file import load_scenario
from realitygap.simulate.experiment import experiments, simulate
from signals import Signals, there

JOINTS = ("shoulder", "elbow")


def drafted(folder: Path, asked: np.ndarray, period: float) -> Draft:
    """The first scenario of a table with these commands (t,), which the joints follow 50 ms later."""
    frame = pd.DataFrame({"time": np.arange(len(asked)) * period})
    late = np.interp(frame["time"] - 0.05, frame["time"], asked)
    for joint in JOINTS:
        frame[f"{joint}_command"], frame[f"{joint}_position"] = asked, late
    frame.to_csv(folder / "run.csv", index=False)
    return init(arm(folder / "arm.urdf"), [folder / "run.csv"], folder / "out")


def clock(period: float) -> np.ndarray:
    return np.arange(0.0, 4.0, period)


STEPS = np.repeat([0.0, 0.4, -0.3, 0.1], 100)
CASES = {
    "a trajectory at 100 Hz": (goal(clock(0.01)), 0.01, False),
    "one at 500 Hz": (goal(clock(0.002)), 0.002, False),
    "with a rest in it": (goal(np.clip(clock(0.01) - 1.0, 0.0, 2.0)), 0.01, False),
    "at 10 Hz": (goal(clock(0.1)), 0.1, True),
    "steps": (STEPS, 0.01, True),
    "told at 50 Hz, read at 500 Hz": (np.repeat(goal(clock(0.02)), 10), 0.002, True),
    "another goal in every sample": (np.random.default_rng(1).choice([-0.5, 0.5], 400), 0.01, True),
    "at rest": (np.zeros(400), 0.01, True),
}


@pytest.mark.parametrize("case", CASES)
def test_samples_of_a_trajectory_are_joined_and_steps_are_held(case: str, tmp_path: Path) -> None:
    asked, period, held = CASES[case]
    draft = drafted(tmp_path, asked, period)
    scenario, _ = read_all(draft.path, JOINTS)
    assert there(scenario.motion).held == held
    assert any("samples of a trajectory" in line and "held: true" in line for line in draft.guessed) != held


def test_the_first_result_is_not_made_of_spikes(tmp_path: Path) -> None:
    """Of a derivative gain that meets the steps of a held command: they were a hundred times the effort there was."""
    file = load_scenario(drafted(tmp_path, goal(clock(0.01)), 0.01).path)
    held = file.override({"motion.held": True})
    efforts = [Signals(simulate(experiments(f)[0], "mujoco").trace).effort[1000:] for f in (file, held)]
    jumps = [np.abs(np.diff(effort, axis=0)).max() for effort in efforts]
    assert jumps[0] < 0.2 * jumps[1]


def test_a_joint_that_is_never_commanded_is_no_warning(tmp_path: Path) -> None:
    """Its column is empty: the others say what the commands are, and numpy says nothing (warnings are errors here)."""
    asked = goal(clock(0.01))
    frame = pd.DataFrame({"time": clock(0.01), "shoulder_command": np.full(len(asked), np.nan)})
    frame = frame.assign(elbow_command=asked, shoulder_position=0.0, elbow_position=asked)
    frame.to_csv(tmp_path / "run.csv", index=False)
    draft = init(arm(tmp_path / "arm.urdf"), [tmp_path / "run.csv"], tmp_path / "out")
    assert any("samples of a trajectory" in line for line in draft.guessed)
