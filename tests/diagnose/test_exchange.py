"""A finding that was chosen before others were known, on the bundled demo with planted effects (synthetic)."""

import numpy as np
import pytest
from demo_problem import demo_problem, suspect_of
from realitygap.diagnose.data.pool import Pool
from realitygap.diagnose.fit.fit import fit, start
from realitygap.diagnose.likelihood.floors import set_floors
from realitygap.diagnose.rehearse.planting import plant_recordings, planted
from realitygap.diagnose.search.exchange import exchange
from realitygap.diagnose.search.found import Found, Step


@pytest.mark.parametrize(
    ("effect", "target", "replaced"),
    [("viscous_friction", "*", True), ("viscous_friction", "shoulder", False), ("rotor_inertia", "elbow", True)],
)
def test_a_finding_makes_room_for_what_explains_more_beside_a_later_one(
    effect: str, target: str, replaced: bool
) -> None:
    problem = demo_problem()
    truth = [suspect_of(problem, e, "shoulder") for e in ("viscous_friction", "constant_effort")]
    robot = plant_recordings(
        problem, [planted(problem, s, times) for s, times in zip(truth, (4.0, 1.0), strict=True)], "drake", np.zeros(2)
    )
    train, judge = robot.of("train"), robot.of("held_out")
    first, (other, last) = suspect_of(problem, effect, target), truth
    with Pool(robot, 2) as pool:
        set_floors(pool, [])
        tried = pool.map(fit, [([start(robot, s)], train, judge) for s in (first, other)])
        both = fit(robot, [tried[0].changes[0], start(robot, last)], train, judge)
        base = fit(robot, [], train, judge)
        steps = [Step(first, base.mean_cost(judge), 2.0, tried=tried), Step(last, 2.0, 1.0)]
        found = Found(base, both, steps)
        assert exchange(pool, found, train, judge, lambda _: None) is replaced
    assert [s.suspect for s in found.steps] == truth
    assert {c.suspect for c in found.fit.changes} == set(truth)
    assert found.fit.mean_cost(judge) < 1.7
