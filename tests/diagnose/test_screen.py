"""Screening follows a suspect as far as it helps: effects much larger than their first try, in the demo (synthetic)."""

import numpy as np
import pytest
from demo_problem import demo_problem, suspect_of
from realitygap.diagnose.data.pool import Pool
from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.likelihood.floors import set_floors
from realitygap.diagnose.rehearse.planting import plant_recordings, planted
from realitygap.diagnose.search.screen import screen


@pytest.fixture(scope="module")
def problem() -> Problem:
    return demo_problem()


@pytest.mark.parametrize(("effect", "times"), [("supply_voltage", 6.0), ("torque_constant", 3.0)])
def test_a_first_guess_is_as_large_as_the_effect(problem: Problem, effect: str, times: float) -> None:
    suspect = suspect_of(problem, effect, "*")
    truth = planted(problem, suspect, times)
    robot = plant_recordings(problem, [truth], "drake", np.zeros(2))
    with Pool(robot, 1) as pool:
        set_floors(pool, [])
        guess = screen(pool, [suspect], [], robot.of("train"))[0]
    (name,) = truth.free
    zero = planted(problem, suspect, 0.0).parameters[name]
    share = (guess.change.parameters[name] - zero) / (truth.parameters[name] - zero)
    assert guess.explained > 0.5
    assert 0.6 < share < 1.5
