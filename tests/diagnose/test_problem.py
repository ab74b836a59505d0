"""What a diagnosis works on, on the bundled demo (synthetic)."""

from dataclasses import replace
from pathlib import Path

import numpy as np
from realitygap.compare.comparison import motions_of
from realitygap.diagnose.data.case import cases_of
from realitygap.diagnose.data.problem import build_problem, exerted, reached
from realitygap.robot.effects.joint import AMPLE, effort_scale
from realitygap.scenario.file import ScenarioFile, load_scenario
from recorded_joint import recorded

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


def test_what_a_motor_is_told_is_in_the_unit_of_its_gain(tmp_path: Path) -> None:
    problem = recorded(tmp_path, {"kind": "effort", "gain": 3.0})
    silent = tuple(replace(c, noise={k: v for k, v in c.noise.items() if k != "effort"}) for c in problem.cases)
    told = max(float(np.abs(c.experiment.commands.value).max()) for c in silent)
    assert np.allclose(exerted(silent), [3.0 * told])


def _most(file: ScenarioFile, joint: int) -> float:
    """The largest effort of the training motions."""
    cases = [c for c in cases_of(motions_of(file)) if c.use != "held_out"]
    return max(float(np.nanmax(np.abs(c.value("effort")[:, joint]))) for c in cases)
