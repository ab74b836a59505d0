"""When a search looks again, on the bundled demo (synthetic)."""

import pytest
from demo_problem import demo_problem, suspect_of
from realitygap.diagnose.data.problem import Change, Problem
from realitygap.diagnose.fit.fit import Fit, start
from realitygap.diagnose.search.found import Found, Step
from realitygap.diagnose.search.search import alone, misleading


@pytest.fixture(scope="module")
def problem() -> Problem:
    return demo_problem()


def found_with(problem: Problem, effect: str, cost: float) -> Found:
    """What a search that brought a gap of 100 down to `cost` with two findings says it found."""
    cases = range(len(problem.cases))
    changes: list[Change] = [start(problem, suspect_of(problem, e, "elbow")) for e in (effect, "viscous_friction")]
    after = Fit(changes, dict.fromkeys(cases, cost))
    return Found(Fit([], dict.fromkeys(cases, 100.0)), after, [Step(c.suspect, 100.0, cost) for c in changes])


@pytest.mark.parametrize(("cost", "again"), [(1.0, False), (10.0, False), (40.0, True)])
def test_what_leaves_much_of_a_gap_may_have_led_astray(problem: Problem, cost: float, again: bool) -> None:
    first = misleading(problem, found_with(problem, "coulomb_friction", cost))
    assert (first.effect if first else "") == ("coulomb_friction" if again else "")


def test_what_is_not_on_the_list_leads_nowhere_else(problem: Problem) -> None:
    assert misleading(problem, found_with(problem, "controller_dead_band", 40.0)) is None


def test_what_was_let_go_may_have_led_astray(problem: Problem) -> None:
    found = found_with(problem, "coulomb_friction", 40.0)
    found.let_go, found.fit = found.fit.changes, found.base
    first = misleading(problem, found)
    assert first is not None
    assert first.effect == "coulomb_friction"


def test_what_the_recordings_told_does_not_lead_astray(problem: Problem) -> None:
    found = found_with(problem, "velocity_filter", 40.0)
    found.told = [found.steps[0].suspect]
    first = misleading(problem, found)
    assert first is not None
    assert first.effect == "viscous_friction"


@pytest.mark.parametrize(
    ("fitted", "judged", "only"), [(3.0, 1.5, False), (10.0, 1.5, True), (10.0, 3.0, False), (100.0, 3.0, True)]
)
def test_a_training_run_far_beyond_all_held_out_runs_shows_a_gap_of_its_own(
    problem: Problem, fitted: float, judged: float, only: bool
) -> None:
    train, judge = problem.of("train"), problem.of("held_out")
    cost = dict.fromkeys([*train, *judge], 1.0) | {train[0]: fitted, judge[0]: judged}
    assert alone(problem, Fit([], cost)) == ([train[0]] if only else [])
