"""The public protocol of the SO-101: the committed scenario has its windows, and its score is as in closed form."""

from dataclasses import replace
from pathlib import Path

import bench_so101
import numpy as np
import pytest
from realitygap.recording import read_recording
from realitygap.scenario.file import load_scenario
from realitygap.trace.trace import Trace
from signals import there

SCENARIO = Path(__file__).parents[2] / "scenarios" / "so101" / "scenario.yaml"
JOINTS = ("shoulder_pan", "shoulder_lift", "elbow_flex", "wrist_flex", "wrist_roll", "gripper")


def test_the_windows_of_the_scenario_are_those_in_which_the_command_moves_most(data_dir: Path) -> None:
    cases = load_scenario(SCENARIO).cases()
    uses = {use: tuple(c.name for c in cases if c.run.use == use) for use in ("train", "held_out")}
    assert uses == {"train": bench_so101.TRAIN, "held_out": bench_so101.JUDGED}
    for case in cases:
        asked = load_scenario(SCENARIO).override({"recordings.episode": case.run.episode}).scenario
        whole = read_recording(case.path, asked, JOINTS, file=SCENARIO)
        assert case.run.window == bench_so101.window(whole)
        begin, end = there(case.run.part)
        assert begin <= case.run.window[0] < case.run.window[1] < end


def moving() -> Trace:
    time = bench_so101.GRID * np.arange(600, dtype=np.float64)
    position = np.column_stack([np.sin(time), 0.5 * np.sin(2 * time)])  # ranges 2 and 1
    return Trace(time, ("a", "b"), position=position, velocity=np.gradient(position, time, axis=0))


def test_the_score_of_a_motion_with_itself_is_zero() -> None:
    trace = moving()
    assert bench_so101.score(trace, trace, there(trace.position))["score"] == 0.0


def test_an_offset_counts_by_the_range_and_a_still_joint_by_the_least_range() -> None:
    trace = moving()
    still = replace(trace, position=np.column_stack([there(trace.position)[:, 0], np.zeros(600)]))
    position = there(still.position)
    found = bench_so101.score(replace(still, position=position + 0.1), still, position)
    assert found["position"] == pytest.approx((0.1 / 2.0 + 0.1 / 0.05) / 2, rel=1e-3)
    assert found["holding"] == pytest.approx(found["position"])
    assert (found["velocity"], found["lag"]) == (0.0, 0.0)
    assert found["score"] == pytest.approx(0.7 * found["position"])


@pytest.mark.parametrize("late", [0, 3, 9])
def test_the_lag_of_a_passing_swing_is_found(late: int) -> None:
    time = bench_so101.GRID * np.arange(600, dtype=np.float64)

    def swing(start: float) -> Trace:
        position = np.exp(-((time - start - 6.0) ** 2)) * np.sin(2 * (time - start))
        return Trace(time, ("a",), position=position[:, None], velocity=np.gradient(position, time)[:, None])

    measured = swing(0.0)
    found = bench_so101.score(swing(late * bench_so101.GRID), measured, there(measured.position))
    assert found["lag"] == pytest.approx(late * bench_so101.GRID)
