"""What the measured effort says along the measured motion, where a search begins."""

from pathlib import Path

import numpy as np
import pytest
from demo_problem import DEMO, demo_problem, planted, suspect_of
from numpy.testing import assert_allclose
from realitygap.diagnose.candidates.starts import guess
from realitygap.diagnose.candidates.suspects import suspects
from realitygap.diagnose.data.along import along_the_motion
from realitygap.diagnose.data.problem import Problem, build_problem
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.data.worker import Query, answer
from realitygap.diagnose.search.search import search
from realitygap.scenario.file import load_scenario
from realitygap.scenario.schema import EffectSpec
from recorded_joint import recorded

MOVING = 0.5
"""A joint this fast does not stick [rad/s]: at rest dry friction may be anything up to its bound."""
SERVO = {"kind": "dc", "gain": 40.0, "supply": 48.0, "torque_constant": 6.0, "resistance": 2.0, "armature": 0.2}
"""Of a joint that lifts 5 kg."""


def followed(problem: Problem) -> Problem:
    found = along_the_motion(problem)
    assert found is not None
    return found


def test_it_holds_the_fitted_motions_and_what_the_servos_say_of_their_joints() -> None:
    problem = demo_problem()
    found = followed(problem)
    assert [c.name for c in found.cases] == [problem.cases[i].name for i in problem.of("train")]
    for case, whole in zip(found.cases, (problem.cases[i] for i in problem.of("train")), strict=True):
        assert set(case.noise) == {"effort"}
        assert case.use == "train"
        assert_allclose(case.noise["effort"], whole.noise["effort"])
        for field in ("armature", "coulomb", "viscous", "static"):
            assert_allclose(case.experiment.plant.drive[field], whole.experiment.plant.drive[field])
        mine, own = ([link.mass for link in c.experiment.plant.model.links] for c in (case, whole))
        assert_allclose(mine, own)


def test_the_true_model_takes_the_effort_that_was_recorded() -> None:
    """Also of planted recordings, which no file holds."""
    missing = guess(demo_problem(), suspect_of(demo_problem(), "coulomb_friction", "elbow")).at({"torque": 0.9})
    found = followed(planted(missing))
    for i, case in enumerate(found.cases):
        way = np.sign(np.where(np.abs(case.value("velocity")) > MOVING, case.value("velocity"), 0.0))
        there, without = (answer(found, Query(of, i, "mujoco", 1.0)) for of in ((missing,), ()))
        assert there is not None
        assert without is not None
        left, before = (
            np.sum(way * found.delta(i, "effort", s), axis=0) / np.sum(way**2, axis=0) for s in (there, without)
        )
        assert abs(left[1]) < 0.05 * abs(before[1])
        assert_allclose(left[0], before[0])  # at the shoulder nothing was missing


def test_without_measured_effort_or_with_a_motion_that_is_followed_there_is_none() -> None:
    problem = demo_problem()
    assert along_the_motion(followed(problem)) is None
    silent = build_problem(load_scenario(DEMO).override({"recordings.effort": "none"}), "mujoco")
    assert along_the_motion(silent) is None


def test_what_single_runs_set_of_their_servos_is_no_hindrance() -> None:
    file = load_scenario(DEMO)
    runs = [dict(run) for run in file.raw["recordings"]["runs"]]
    runs[1]["with"] = {"servos.drive.gain": 4.0, "servos.drive.friction": {"coulomb": 0.5}}
    found = followed(build_problem(file.override({"recordings.runs": runs}), "mujoco"))
    coulomb = {c.name: c.experiment.plant.drive["coulomb"][0] for c in found.cases}
    assert coulomb["sines_1_rep1"] == 0.5
    assert coulomb["triangle_1"] == 0.2756


def test_what_a_scenario_states_stands_there_too_but_for_what_no_followed_motion_shows() -> None:
    """An unnamed effort over the speed, friction that excludes the servo's, and a gain; none over the error."""
    table = {
        "effect": "effort_map",
        "target": "elbow",
        "variables": ["speed"],
        "knots": [[-1.0, 1.0]],
        "values": [-0.2, 0.2],
    }
    friction = {"effect": "stribeck_friction", "target": "elbow", "static": 0.5, "coulomb": 0.3, "velocity": 0.2}
    gain = {"effect": "controller_gain", "target": "*", "gain": 4.0}
    file = load_scenario(DEMO).override({"effects": [table, friction, gain]})
    for case in followed(build_problem(file, "mujoco")).cases:
        plant = case.experiment.plant
        assert len(plant.maps) == 1
        assert plant.drive["coulomb"].tolist() == [0.2756, 0.3]
    over_error = file.override({"effects": [table | {"variables": ["error"]}]})
    assert along_the_motion(build_problem(over_error, "mujoco")) is None


def test_the_constant_of_a_motor_is_not_told_by_an_effort_that_was_told_as_one() -> None:
    problem = build_problem(load_scenario(DEMO).override({"recordings.effort": {"measures": "motor"}}), "mujoco")
    assert "torque_constant" in {s.effect for s in suspects(problem)}
    assert "torque_constant" not in {s.effect for s in suspects(followed(problem))}


@pytest.mark.parametrize("missing", [2.0, 0.0])
def test_a_search_begins_there_where_that_helps_the_motion(missing: float, tmp_path: Path) -> None:
    friction = EffectSpec(effect="viscous_friction", target="*", coefficient=missing)
    problem, said = recorded(tmp_path, SERVO, friction), list[str]()
    with Simulations(problem, 2) as simulations:
        found = search(simulations, [suspect_of(problem, "viscous_friction", "lift")], [], said.append)
    assert said[0] == "along the measured motion"
    named = {c.suspect.effect: c.parameters for c in found.best.fit.changes}
    if missing:
        assert named["viscous_friction"]["coefficient"] == pytest.approx(missing, rel=0.02)
        assert said[-2].startswith("viscous_friction at lift")  # what it begins with, and no round adds anything
    else:
        assert not named
        assert not any("viscous" in line for line in said)
