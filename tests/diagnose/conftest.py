"""What laws on the bundled demo (synthetic) share."""

from collections.abc import Iterator

import pytest
from demo_problem import demo_problem
from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.data.simulations import Simulations


@pytest.fixture(scope="module")
def problem() -> Problem:
    """The demo as a diagnosis in MuJoCo sees it."""
    return demo_problem()


@pytest.fixture(scope="module")
def simulations(problem: Problem) -> Iterator[Simulations]:
    """Of that problem, in two processes."""
    with Simulations(problem, 2) as made:
        yield made
