"""The residual of a model without which nothing can be said; where it cannot be simulated, a sentence on why."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from realitygap_engines import Diverged, Failed, Unsupported

from realitygap.diagnose.data.changes import Change
from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.data.worker import Query, simulated
from realitygap.diagnose.fit.motions import residual
from realitygap.files.errors import InputError
from realitygap.page.style import engine_label
from realitygap.robot.drive import Array


def demanded(simulations: Simulations, changes: Sequence[Change], cases: Sequence[int]) -> Array:
    """The stacked residual of some cases with changes.

    Raises:
        InputError: for a model that the searching engine cannot simulate: in which run, and what it came to.
    """
    found = residual(simulations, changes, cases)
    if found is None:
        raise InputError(_why(simulations, changes, cases))
    return found


@dataclass(frozen=True)
class _Outcome:
    """Asks what a simulation that failed came to; "" where it is done."""

    query: Query

    def answer(self, problem: Problem, /) -> str:
        case, plant = problem.cases[self.query.case], problem.changed_plant(self.query.changes, self.query.case)
        try:
            simulated(case, plant, self.query)
        except Diverged as error:
            rate = f"a higher physics.step_rate than {case.experiment.scenario.physics.step_rate:g} Hz"
            gains = ", or servos with lower gains and more damping" if plant.model.joints else ""
            return f"{error}; expected {rate}{gains}"
        except (Failed, Unsupported) as error:
            return f"{error}; expected another engine to search in (the first --engine)"
        return ""


def _why(simulations: Simulations, changes: Sequence[Change], cases: Sequence[int]) -> str:
    """Which run cannot be simulated, and why."""
    problem = simulations.problem
    queries = [simulations.query(changes, c) for c in cases]
    (failed, *_) = (q for q, a in zip(queries, simulations.ask(queries), strict=True) if a is None)
    case = problem.cases[failed.case]
    (told,) = simulations.each([_Outcome(failed)])
    what = "the scenario's own model" + "".join(f", with {c.suspect}" for c in changes)
    why = told or "it takes its process down; expected another engine to search in (the first --engine)"
    return f"{case.experiment.where}: {engine_label(problem.engine)} cannot simulate {what}, in {case.name}: {why}"
