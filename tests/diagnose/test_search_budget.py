"""How long a diagnosis looks for more: so many engine steps of the bundled demo (synthetic), however fast they are."""

import time
from dataclasses import replace

import pytest
from realitygap.cli.main import main
from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.search_budget import AGAIN, EACH, FEWEST, MINUTES, UNLIMITED, SearchBudget


def test_steps_count_as_they_are_asked_for_however_many_take_them(problem: Problem) -> None:
    counts = []
    for workers in (1, 2):
        with Simulations(problem, workers) as simulations:
            simulations.of([], [0, 1])
            simulations.of([], [0])  # remembered, and asked for
            simulations.of([], [0], coarse=[0.5] * len(problem.cases))
            counts.append(simulations.steps)
    first, second = (sum(e.duration * e.scenario.physics.step_rate for e in problem.cases[c].pieces) for c in (0, 1))
    assert counts == pytest.approx([2.5 * first + second] * 2)


def test_more_is_looked_for_until_the_steps_or_the_time_are_over() -> None:
    now = time.monotonic()
    assert not UNLIMITED.over(1e30)
    ordinary = SearchBudget.of(6, None, now)
    assert not ordinary.over(0.99 * ordinary.steps)
    assert ordinary.over(1.01 * ordinary.steps)
    assert SearchBudget.of(6, None, now - 3600.0).over(0.0), "an engine may be slow"
    assert SearchBudget.of(0, None, now).steps == SearchBudget.of(FEWEST, None, now).steps, "a body without joints"
    assert SearchBudget.of(1, None, now).steps > ordinary.steps, "what is around a step counts, too"
    assert SearchBudget.of(20, None, now).steps * 20 > ordinary.steps * 6, "a humanoid takes longer"


def test_the_help_says_its_unit_and_what_the_end_of_the_time_means(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["diagnose", "--help"])
    said = " ".join(capsys.readouterr().out.split())
    assert "how many minutes, by the clock" in said
    assert "then the search stops, and what it found by then is judged on held-out runs and written" in said
    assert f"about {MINUTES:g} minutes, or {60 * EACH:g} s for every joint" in said


def test_a_round_that_explains_much_again_costs_nothing_of_it() -> None:
    ordinary = SearchBudget.of(6, None, time.monotonic())
    assert ordinary.beside(1e6, (AGAIN + 0.01) * 900.0, 900.0) == replace(ordinary, steps=ordinary.steps + 1e6)
    assert ordinary.beside(1e6, (AGAIN - 0.01) * 900.0, 900.0) == ordinary


def test_minutes_that_are_asked_for_are_of_the_clock() -> None:
    now = time.monotonic()
    assert not SearchBudget.of(6, 1.0, now).over(1e30)
    assert SearchBudget.of(6, 1.0, now - 61.0).over(0.0)


def test_a_part_of_the_time_that_is_left_may_go_into_the_beginning() -> None:
    now = time.monotonic()
    assert SearchBudget(1e6, now + 30.0).part(1 / 3, 5.0).until == pytest.approx(now + 10.0, abs=0.5)
    assert UNLIMITED.part(1 / 3, 5.0) == SearchBudget(5.0)
