"""Which motions are kept back, on the bundled demo (synthetic)."""

import numpy as np
import pytest
from demo_problem import demo_problem
from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.data.split import keep_back


@pytest.fixture
def problem() -> Problem:
    return demo_problem()


def test_of_a_run_that_alone_shows_a_gap_the_rest_is_kept_back(problem: Problem) -> None:
    train, judge = problem.of("train"), problem.of("held_out")
    time = problem.cases[train[0]].measured.time
    said = keep_back(problem.cases, [train[0]])
    assert problem.cases[train[0]].name in said
    assert problem.of("train") == train
    assert problem.of("held_out")[: len(judge)] == judge
    first, rest = problem.cases[train[0]], problem.cases[-1]
    assert rest.use == "held_out"
    assert np.array_equal(np.concatenate([first.measured.time, rest.measured.time]), time)


def test_a_run_too_short_to_cut_stays_whole(problem: Problem) -> None:
    case = problem.cases[problem.of("train")[0]]
    case.measured = case.measured.between(-np.inf, float(case.measured.time[40]))
    before = len(problem.cases)
    assert keep_back(problem.cases, [problem.cases.index(case)]) == ""
    assert len(problem.cases) == before
