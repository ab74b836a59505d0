"""What a diagnosis works on, on the bundled demo (synthetic)."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from realitygap.compare.comparison import motions_of
from realitygap.diagnose.data.case import cases_of
from realitygap.diagnose.data.problem import build_problem, exerted, lagged, reached
from realitygap.robot.drive import EFFORT
from realitygap.robot.effects import EFFECTS
from realitygap.robot.effects.joint import AMPLE, effort_scale
from realitygap.robot.effects.power_stage import SOON
from realitygap.scenario.file import ScenarioFile, load_scenario
from recorded_joint import recorded
from scipy.spatial.transform import Rotation

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


def test_a_joint_is_not_rated_for_far_more_than_it_was_seen_to_give() -> None:
    """As where a URDF says 1000 N·m; a limit that is near what the motor gave is taken as stated."""
    servo = {"name": "drive", "joints": "*", "kind": "pid", "kp": 60.0, "kd": 2.0}
    file = load_scenario(DEMO).override({"servos": [servo]})
    plant = build_problem(file, "mujoco").plant
    assert plant.exerted is not None
    assert np.allclose(plant.exerted, [_most(file, joint) for joint in range(2)])
    for stated, rated in ((1000.0, AMPLE * plant.exerted[0]), (15.0, 15.0)):
        plant.drive["effort_limit"] = stated
        assert effort_scale(plant, 0) == rated
    plant.exerted = None
    assert effort_scale(plant, 0) == 15.0


def test_protection_is_first_looked_for_among_the_errors_that_were_recorded() -> None:
    problem = build_problem(load_scenario(DEMO), "mujoco")
    plant, train = problem.plant, [c for c in problem.cases if c.use == "train"]
    assert plant.lagged is not None
    for joint in range(2):
        largest = 0.0
        for case in train:
            commands, at = case.experiment.commands, case.value("position")[:, joint]
            for t, q in zip(case.measured.time, at, strict=True):
                told = commands.value[max(np.flatnonzero(commands.time <= t), default=0), joint]
                largest = max(largest, abs(told - q))
        assert plant.lagged[joint] == pytest.approx(largest)
        first = EFFECTS["effort_limit"].first_size(plant, joint)
        assert first["beyond"] == pytest.approx(SOON * largest)
    no_position = replace(train[0].experiment.plant, drive=plant.drive.copy())
    no_position.drive["meaning"] = EFFORT
    silent = replace(train[0], experiment=replace(train[0].experiment, plant=no_position))
    assert np.allclose(lagged([silent]), 0.0)


def test_what_a_motor_is_told_is_in_the_unit_of_its_gain(tmp_path: Path) -> None:
    problem = recorded(tmp_path, {"kind": "effort", "gain": 3.0})
    silent = tuple(replace(c, noise={k: v for k, v in c.noise.items() if k != "effort"}) for c in problem.cases)
    told = max(float(np.abs(c.experiment.commands.value).max()) for c in silent)
    assert np.allclose(exerted(silent), [3.0 * told])


def test_a_difference_is_what_the_second_is_beyond_the_first() -> None:
    """Of judged joints; of orientations the rotation from the first to the second, in the axes of the first."""
    problem = replace(build_problem(load_scenario(DEMO), "mujoco"), judged=np.array([False, True]))
    a, b = np.zeros((3, 2)), np.tile([0.5, 0.2], (3, 1))
    np.testing.assert_allclose(problem.difference("position", a, b), np.full((3, 1), 0.2))
    here, turn = Rotation.from_rotvec([0.3, -0.2, 1.0]), np.array([0.02, -0.01, 0.03])
    one, other = (np.asarray(r.as_quat(scalar_first=True))[None] for r in (here, here * Rotation.from_rotvec(turn)))
    np.testing.assert_allclose(problem.difference("base_quaternion", one, other), [turn], atol=1e-9)
    np.testing.assert_allclose(problem.difference("base_quaternion", one, -other), [turn], atol=1e-9)


def test_a_rotation_is_as_uncertain_as_the_quaternion_that_tells_it() -> None:
    problem, random, sigma = build_problem(load_scenario(DEMO), "mujoco"), np.random.default_rng(2), 2e-3
    still = np.tile([0.5, -0.5, 0.5, 0.5], (20000, 1))
    away = sigma * random.standard_normal(still.shape)
    away -= still * np.sum(away * still, axis=1, keepdims=True)  # it has unit length
    turns = problem.difference("base_quaternion", still, still + away)
    size = np.full((1, 4), np.sqrt(np.mean(away**2)))
    np.testing.assert_allclose(turns.std(axis=0), problem.deviation("base_quaternion", size)[0], rtol=0.03)


def test_the_noise_of_a_mean_is_that_of_one_repetition_over_the_root_of_their_number() -> None:
    """As motions that were repeated tell it together, for each of all."""
    cases = cases_of(motions_of(load_scenario(DEMO)))
    spreads = [c.spread["position"] for c in cases if c.spread]
    assert spreads
    single = np.sqrt(np.mean(np.square(spreads), axis=0))
    assert {c.repetitions for c in cases} > {1}
    for case in cases:
        np.testing.assert_allclose(case.noise["position"], single / np.sqrt(case.repetitions))


def _most(file: ScenarioFile, joint: int) -> float:
    """The largest effort of the training motions."""
    cases = [c for c in cases_of(motions_of(file)) if c.use != "held_out"]
    return max(float(np.nanmax(np.abs(c.value("effort")[:, joint]))) for c in cases)
