"""A finding that was chosen before others were known, on the bundled demo with planted effects (synthetic)."""

from pathlib import Path

import numpy as np
import pytest

from harness.diagnose.exchange import exchange
from harness.diagnose.fit import fit, start
from harness.diagnose.floors import set_floors
from harness.diagnose.found import Found, Step
from harness.diagnose.planting import plant_recordings, planted
from harness.diagnose.pool import Pool
from harness.diagnose.problem import Suspect, build_problem
from harness.diagnose.suspects import suspects
from harness.scenario_file import load_scenario

DEMO = Path(__file__).parents[1] / "scenarios" / "demo" / "scenario.yaml"


@pytest.mark.parametrize(
    ("effect", "target", "replaced"),
    [("viscous_friction", "*", True), ("viscous_friction", "shoulder", False), ("rotor_inertia", "elbow", True)],
)
def test_a_finding_makes_room_for_what_explains_more_beside_a_later_one(
    effect: str, target: str, replaced: bool
) -> None:
    problem = build_problem(load_scenario(DEMO), "mujoco")

    def suspect(effect: str, target: str) -> Suspect:
        return next(s for s in suspects(problem) if s.effect == effect and s.target == target)

    truth = (suspect("viscous_friction", "shoulder"), suspect("constant_effort", "shoulder"))
    robot = plant_recordings(
        problem, [planted(problem, s, times) for s, times in zip(truth, (4.0, 1.0), strict=True)], "drake", np.zeros(2)
    )
    train, judge = robot.of("train"), robot.of("held_out")
    first, other, last = suspect(effect, target), suspect("viscous_friction", "shoulder"), truth[1]
    with Pool(robot, 2) as pool:
        set_floors(pool, [])
        tried = pool.map(fit, [([start(robot, s)], train, judge) for s in (first, other)])
        both = fit(robot, [tried[0].changes[0], start(robot, last)], train, judge)
        base = fit(robot, [], train, judge)
        steps = [Step(first, base.mean_cost(judge), 2.0, tried=tried), Step(last, 2.0, 1.0)]
        found = Found(base, both, steps)
        assert exchange(pool, found, train, judge, lambda _: None) is replaced
    assert [s.suspect for s in found.steps] == list(truth)
    assert {c.suspect for c in found.fit.changes} == set(truth)
    assert found.fit.mean_cost(judge) < 1.7
