"""What is not on the list of effects is told and not named, on the bundled demo (synthetic)."""

import pytest
from demo_problem import demo_problem, suspect_of
from realitygap.diagnose.data.pool import Pool
from realitygap.diagnose.data.problem import Change, Problem
from realitygap.diagnose.fit.fit import Fit, costs, fit, start
from realitygap.diagnose.fit.probes import with_values
from realitygap.diagnose.search.found import Found, Step
from realitygap.diagnose.search.outside import set_aside


@pytest.fixture(scope="module")
def problem() -> Problem:
    return demo_problem()


def change(problem: Problem, effect: str, **values: float) -> Change:
    suspect = suspect_of(problem, effect, "elbow")
    return with_values(start(problem, suspect), values)


def set_aside_beside(problem: Problem, beside: Change) -> tuple[Found, list[str]]:
    """What stays of a dead band, which is not on the list, and a finding beside it."""
    train, judge = problem.of("train"), problem.of("held_out")
    both = [change(problem, "controller_dead_band", width=1e-3), beside]
    base = fit(problem, [], train, judge)
    found = Found(base, Fit(both, costs(problem, both, [*train, *judge])), [Step(c.suspect, 9.0, 1.0) for c in both])
    with Pool(problem, 1) as pool:
        notes = set_aside(pool, found, lambda _: None)
    return found, notes


def test_a_finding_that_mends_nothing_without_it_is_not_named(problem: Problem) -> None:
    found, notes = set_aside_beside(problem, change(problem, "joint_compliance", stiffness=1e5))
    assert len(notes) == 1
    assert "outside the list of effects" in notes[0]
    assert found.fit is found.base
    assert not found.steps
    assert any("joint_compliance at elbow" in sentence for sentence in found.refused)


def test_a_finding_that_mends_much_without_it_stays(problem: Problem) -> None:
    found, notes = set_aside_beside(problem, change(problem, "coulomb_friction", torque=0.6447))
    assert len(notes) == 1
    assert [c.suspect.effect for c in found.fit.changes] == ["coulomb_friction"]
    assert [s.suspect.effect for s in found.steps] == ["coulomb_friction"]
    assert not found.refused
