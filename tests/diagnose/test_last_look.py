"""The last look at all findings: what is let go, on the bundled demo (synthetic)."""

import pytest
from demo_problem import demo_problem, suspect_of
from realitygap.diagnose.data.pool import Pool
from realitygap.diagnose.data.problem import Change, Problem
from realitygap.diagnose.fit.fit import Fit, fit, start
from realitygap.diagnose.fit.probes import with_values
from realitygap.diagnose.search.found import Found, Step
from realitygap.diagnose.search.last_look import abstain, least_missed


@pytest.fixture(scope="module")
def problem() -> Problem:
    return demo_problem()


def change(problem: Problem, effect: str, joint: str, **values: float) -> Change:
    suspect = suspect_of(problem, effect, joint)
    return with_values(start(problem, suspect), values)


def found_with(problem: Problem, *changes: Change, cost: float) -> Found:
    """What a search that brought a gap of 100 down to `cost` says it found."""
    cases = range(len(problem.cases))
    base = Fit([], dict.fromkeys(cases, 100.0))
    return Found(base, Fit(list(changes), dict.fromkeys(cases, cost)), [Step(c.suspect, 100.0, cost) for c in changes])


def test_findings_that_make_a_signal_far_worse_are_not_named(problem: Problem) -> None:
    judge = problem.of("held_out")
    stuck = found_with(problem, change(problem, "coulomb_friction", "shoulder", torque=5.0), cost=1.0)
    abstain(problem, stuck, judge)
    assert not stuck.fit.changes
    assert not stuck.steps
    assert [c.suspect.effect for c in stuck.let_go] == ["coulomb_friction"]
    assert any("gets far worse" in sentence for sentence in stuck.refused)


def test_findings_that_explain_and_hurt_nothing_stay(problem: Problem) -> None:
    judge = problem.of("held_out")
    right = fit(problem, [change(problem, "coulomb_friction", "elbow", torque=0.4)], problem.of("train"), judge)
    found = found_with(problem, *right.changes, cost=1.0)
    abstain(problem, found, judge)
    assert [c.suspect.effect for c in found.fit.changes] == ["coulomb_friction"]
    assert not found.refused


def test_what_keeps_another_finding_from_becoming_absurd_stays(problem: Problem) -> None:
    """However little the held-out motions miss it."""
    viscous = change(problem, "viscous_friction", "shoulder", coefficient=0.1)
    falling = change(problem, "stribeck_friction", "elbow", static=0.5, coulomb=0.2)
    rising = with_values(falling, {"static": 0.2, "coulomb": 0.5})
    found = found_with(problem, viscous, falling, cost=1.0)
    cases = range(len(problem.cases))
    found.fits = {
        (falling,): Fit([rising], dict.fromkeys(cases, 1.01)),
        (viscous,): Fit([viscous], dict.fromkeys(cases, 30.0)),
    }
    with Pool(problem, 1) as pool:
        least = least_missed(pool, found, found.fit, found.fit.changes, problem.of("train"), problem.of("held_out"))
    assert least is not None
    assert least[0] == falling.suspect
