"""What laws on the bundled demo (synthetic) share."""

from collections.abc import Callable, Iterator
from typing import Any

import pytest
from demo_problem import demo_problem
from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.result.diagnosis import Diagnosis
from told_story import judged_demo, told_as


@pytest.fixture(scope="module")
def problem() -> Problem:
    """The demo as a diagnosis in MuJoCo sees it."""
    return demo_problem()


@pytest.fixture(scope="module")
def simulations(problem: Problem) -> Iterator[Simulations]:
    """Of that problem, in two processes."""
    with Simulations(problem, 2) as made:
        yield made


@pytest.fixture(scope="session")
def judged() -> Any:
    """The demo with its floors, the fit of what is missing, and what was simulated before and after: no search."""
    return judged_demo()


@pytest.fixture(scope="session")
def told(judged: Any) -> Callable[[str], Diagnosis]:
    """A function from a verdict to the diagnosis that has it."""
    return lambda verdict: told_as(judged, verdict)
