"""What cannot be told apart, on the bundled demo (synthetic)."""

import pytest
from demo_problem import demo_problem, suspect_of
from realitygap.diagnose.data.pool import Pool
from realitygap.diagnose.data.problem import Change, Problem
from realitygap.diagnose.fit.fit import fit, start
from realitygap.diagnose.judge.rivals import rivals
from realitygap.diagnose.search.found import Found, Step
from realitygap.diagnose.search.screen import Screened


@pytest.fixture(scope="module")
def problem() -> Problem:
    return demo_problem()


def change(problem: Problem, effect: str, target: str) -> Change:
    return start(problem, suspect_of(problem, effect, target))


@pytest.mark.parametrize(
    ("named", "twin"),
    [
        (("base_tilt", "base"), ("joint_offset", "shoulder")),
        (("link_inertia", "upper_arm"), ("rotor_inertia", "shoulder")),
    ],
)
def test_the_same_thing_on_one_joint_is_listed_however_little_it_promised(
    problem: Problem, named: tuple[str, str], twin: tuple[str, str]
) -> None:
    train, judge = problem.of("train"), problem.of("held_out")
    own, same, elsewhere = (change(problem, *what) for what in (named, twin, (twin[0], "elbow")))
    ranked = [Screened(own, 1.0), Screened(same, 0.0), Screened(elsewhere, 0.0)]
    base, found = (fit(problem, changes, train, judge) for changes in ([], [own]))
    with Pool(problem, 1) as pool:
        listed = rivals(pool, Found(base, found, [Step(own.suspect, 2.0, 1.0, ranked)]))
    assert [(r.suspect.effect, r.suspect.target) for r in listed[own.suspect]] == [twin]
