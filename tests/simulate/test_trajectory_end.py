"""A trajectory that the end of its recording cuts off goes on there: its rate does not break off."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import realitygap_engines as engines
from realitygap.scenario.file import load_scenario
from realitygap.simulate.commands import Commands, going_on
from realitygap.simulate.library import simulate
from signals import there

SLOPE, KD = 0.5, 1.0
"""rad/s of the command, and N·m·s/rad."""
URDF = (
    '<robot name="arm"><link name="base"/><link name="link"><inertial><mass value="1"/>'
    '<inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>'
    '<joint name="turn" type="continuous"><parent link="base"/><child link="link"/><axis xyz="0 0 1"/></joint></robot>'
)


@pytest.mark.parametrize("engine", engines.available())
@pytest.mark.parametrize("part", [None, [0.0, 0.5]])
def test_the_effort_of_the_last_samples_is_that_of_those_before(
    engine: str, part: list[float] | None, tmp_path: Path
) -> None:
    (tmp_path / "arm.urdf").write_text(URDF)
    time = np.arange(101) * 0.01
    frame = pd.DataFrame({"time": time, "command_turn": SLOPE * time, "position_turn": SLOPE * time})
    frame.to_csv(tmp_path / "ramp.csv", index=False)
    run = {"path": str(tmp_path / "ramp.csv")} | ({} if part is None else {"part": part})
    scenario = load_scenario(
        {
            "name": "ramp",
            "robot": {"urdf": str(tmp_path / "arm.urdf"), "base": "fixed"},
            "servos": [{"joints": "*", "kind": "pid", "kp": 20.0, "kd": KD}],
            "motion": {"recorded": "command", "held": False},
            "recordings": {"runs": [run]},
        }
    )
    effort = there(simulate(scenario, engine).effort)[:, 0]
    assert abs(effort[200]) < 0.05 * SLOPE * KD, "it follows"
    np.testing.assert_allclose(effort[-3:], effort[-10], atol=0.02 * SLOPE * KD)


def test_one_that_ended_before_or_is_held_stays() -> None:
    """It was not cut off: one more sample would have been recorded."""
    time, value = np.array([0.0, 0.1, 0.2]), np.array([[0.0, 1.0], [1.0, np.nan], [3.0, 2.0]])
    for commands, duration in ((Commands(time, value, held=False), 0.31), (Commands(time, value), 0.2)):
        assert going_on(commands, duration) is commands
    further = going_on(Commands(time, value, held=False), 0.2)
    np.testing.assert_allclose(further.time, [0.0, 0.1, 0.2, 0.3])
    np.testing.assert_array_equal(further.value[-1], [5.0, 2.0])
