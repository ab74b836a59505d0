"""What a motion that was recorded twice is compared with, and the floors beside it: what was planted comes out."""

import numpy as np
import pandas as pd
import pytest
import yaml
from realitygap.compare.comparison import RepeatedMotion, compare, motions_of
from realitygap.compare.table import table
from realitygap.scenario.file import ScenarioFile, load_scenario
from realitygap.simulate.experiment import simulate
from signals import Signals, there

LATE = 0.3
"""How much later the second recording's motion is on its own clock [s]."""
APART = np.radians(2.0)
"""How far the repetitions are from their mean, to either side [rad]."""
ARM = (
    '<robot name="arm"><link name="base"/><link name="link"><inertial><origin xyz="0 0 -0.2"/><mass value="2"/>'
    '<inertia ixx="0.05" iyy="0.05" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>'
    '<joint name="lift" type="revolute"><parent link="base"/><child link="link"/><axis xyz="0 1 0"/>'
    '<limit lower="-2.6" upper="2.6" effort="90" velocity="60"/></joint></robot>'
)
SCENARIO = {
    "name": "arm",
    "robot": {"urdf": "robot.urdf", "base": "fixed"},
    "servos": [{"joints": "*", "kind": "pid", "kp": 60.0, "kd": 3.0, "armature": 0.01}],
    "motion": {"recorded": "command"},
    "physics": {"step_rate": 250},
    "recordings": {"effort": "none", "runs": [{"path": "first.csv"}, {"path": "second.csv"}]},
}


def swing(time: np.ndarray) -> np.ndarray:
    """No two moments of it are alike."""
    return np.asarray(0.5 * np.sin(3.0 * time) + 0.2 * np.sin(7.7 * time))


@pytest.fixture(scope="module")
def arm(tmp_path_factory: pytest.TempPathFactory) -> ScenarioFile:
    """Two recordings of one swing, of which the second begins and ends later, each as far from it as the other."""
    folder = tmp_path_factory.mktemp("arm")
    (folder / "robot.urdf").write_text(ARM)
    (folder / "scenario.yaml").write_text(yaml.safe_dump(SCENARIO))
    for name, late, off in (("first", 0.0, -APART), ("second", LATE, APART)):
        clock = 0.01 * np.arange(401)
        command = swing(clock - late)
        told = {"time": clock, "command_lift": command, "position_lift": command + off}
        pd.DataFrame(told | {"velocity_lift": np.gradient(command, clock)}).to_csv(folder / f"{name}.csv", index=False)
    return load_scenario(folder / "scenario.yaml")


@pytest.fixture(scope="module")
def motion(arm: ScenarioFile) -> RepeatedMotion:
    (found,) = motions_of(arm)
    return found


def test_repetitions_are_one_motion_on_the_first_ones_clock_where_both_were_recorded(motion: RepeatedMotion) -> None:
    assert motion.shifts == pytest.approx((0.0, LATE), abs=1e-4)
    measured = Signals(there(motion.measured))
    np.testing.assert_allclose(measured.time[[0, -1]], [0.0, 4.0 - LATE], atol=0.011)
    np.testing.assert_allclose(measured.position[:, 0], swing(measured.time), atol=1e-3)
    np.testing.assert_allclose(measured.command[:, 0], swing(measured.time), atol=2e-2)  # held from sample to sample


def test_what_repetitions_differ_by_is_the_floor_in_the_unit_of_the_gap(motion: RepeatedMotion) -> None:
    rows = {r.signal: r for r in compare(motion, "mujoco", floors=False).rows}
    assert rows["position"].noise_floor == pytest.approx(np.degrees(2.0 * APART), rel=1e-3)
    assert rows["velocity"].noise_floor < 0.02 * rows["velocity"].mean_abs
    assert rows["position"].unit == "deg"


def test_the_simulations_of_repetitions_are_compared_at_the_same_moments_of_the_motion(motion: RepeatedMotion) -> None:
    done = compare(motion, "mujoco", floors=False)
    simulated, clock = Signals(there(done.simulated)), there(motion.measured).time
    each = [Signals(t.at(clock + s)).position for t, s in zip(done.repetitions.values(), motion.shifts, strict=True)]
    settled = clock > 0.6  # the second one begins in the middle of another swing
    np.testing.assert_allclose(each[0][settled], each[1][settled], atol=2e-3)
    np.testing.assert_allclose(simulated.position, np.mean(each, axis=0), atol=1e-12)


@pytest.mark.parametrize("repeated", [False, True])
def test_the_numerical_floor_is_how_far_half_the_step_moves_the_motion(repeated: bool, arm: ScenarioFile) -> None:
    runs = SCENARIO["recordings"]["runs"][: 1 + repeated]  # type: ignore[index]
    (motion,) = motions_of(arm.override({"recordings.runs": runs}))
    clock, moved = there(motion.measured).time, []
    for e, shift in zip(motion.experiments, motion.shifts, strict=True):
        coarse, fine = (Signals(simulate(e, "mujoco", step_rate=rate).trace.at(clock + shift)) for rate in (250, 500))
        moved.append(fine.position - coarse.position)
    frame = table(compare(motion, "mujoco").rows).set_index("signal")
    expected = np.degrees(np.mean(np.abs(np.mean(moved, axis=0))))
    assert expected > 1e-3
    assert frame.loc["position", "numerical_floor"] == pytest.approx(expected, rel=1e-6)
    assert frame.loc["position", "group"] == "moving"
