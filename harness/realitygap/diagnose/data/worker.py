"""A process that simulates motions of a problem: `python -m realitygap.diagnose.data.worker`.

It reads pickled messages from its standard input and answers on its standard output: first the problem, then one
question after the other. It ends when its input ends, so that it never outlives the process that started it.
"""

from __future__ import annotations

import gc
import os
import pickle
import sys
from dataclasses import dataclass, replace
from typing import Protocol, TypeVar

import numpy as np
from realitygap_engines import Diverged, Failed, Unsupported

from realitygap.diagnose.data.case import Case
from realitygap.diagnose.data.changes import Change
from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.data.push import Push
from realitygap.diagnose.data.windows import joined
from realitygap.files.lifeline import end_with
from realitygap.robot.drive import Array
from realitygap.robot.plant import Plant
from realitygap.simulate.experiment import Experiment, simulate
from realitygap.simulate.footing import SPAN, beyond, footing_of
from realitygap.simulate.opened import kept_open
from realitygap.trace.trace import Trace

Answer_co = TypeVar("Answer_co", covariant=True)


class Question(Protocol[Answer_co]):
    """What a process is asked: it can be pickled, and so can its answer."""

    def answer(self, problem: Problem, /) -> Answer_co:
        """The answer, of the problem that the process knows."""


@dataclass(frozen=True)
class Query:
    """One simulation: of a case with changes, in an engine, at a multiple of the step rate.

    `push` is a disturbing torque on a joint; `jumps` asks for how far the effort jumps within a step as well, `footing`
    for how far a robot is from keeping its feet; `nudge` seeds other states at which windows begin, as far from the
    measured ones as those are uncertain.
    """

    changes: tuple[Change, ...]
    case: int
    engine: str
    finer: float = 1.0
    push: Push | None = None
    jumps: bool = False
    nudge: int | None = None
    footing: bool = False

    def answer(self, problem: Problem, /) -> dict[str, Array] | None:
        """The signals at the measured stamps; None for a simulation that failed."""
        return answer(problem, self)


def answer(problem: Problem, query: Query) -> dict[str, Array] | None:
    """The signals at the measured stamps; None for a simulation that failed."""
    case, plant = problem.cases[query.case], problem.changed_plant(query.changes, query.case)
    if not all(c.suspect.possible(plant) for c in query.changes):  # a compliance whose rotor was left out
        return None
    try:
        trace = simulated(case, plant, query)
    except (Diverged, Failed, Unsupported):
        return None
    signals = problem.signals(query.case)
    at = trace.only(signals).at(case.measured.time)
    out = {s: np.asarray(getattr(at, s)) for s in signals}
    if query.jumps and "effort" in out:
        h = case.experiment.scenario.timestep
        effort = trace.only(["effort"])
        before, after = (np.asarray(effort.at(case.measured.time + d).effort) for d in (-h, h))
        out["jump"] = np.abs(after - before)
    if query.footing:
        footing = footing_of(plant.loaded(), trace.between(case.measured.time[0] - SPAN, np.inf))
        out["footing"] = np.interp(case.measured.time, footing.time, beyond(footing))
    return out


def simulated(case: Case, plant: Plant, query: Query) -> Trace:
    """The whole motion of a query, of a changed plant, at every step.

    Raises:
        Unsupported, Diverged, Failed: as they say.
    """
    return joined(case.pieces, [_simulated(plant, query, e, number) for number, e in enumerate(case.pieces)])


def _simulated(plant: Plant, query: Query, experiment: Experiment, number: int) -> Trace:
    """One window, the so manieth, or all of a motion."""
    if query.push is not None:
        plant = plant.copy()
        query.push.on(plant, experiment)
    if query.nudge is not None and experiment.midway is not None:
        random = np.random.default_rng([query.nudge, number])
        experiment = replace(experiment, midway=experiment.midway.nudged(random))
    rate = experiment.scenario.physics.step_rate * query.finer
    return simulate(experiment.with_plant(plant), query.engine, step_rate=rate).trace


def main() -> None:
    """Answer until the input ends."""
    asked = sys.stdin.buffer
    end_with(os.getppid())  # also in the middle of a simulation
    told = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # what an engine prints is no answer
    try:
        problem = pickle.load(asked)
        gc.freeze()  # packages and problem stay
        while True:
            question: Question[object] = pickle.load(asked)
            result: tuple[bool, object]
            try:
                result = True, question.answer(problem)
            except Exception as error:  # told to the one who asked
                result = False, f"{type(error).__name__}: {error}"
            pickle.dump(result, told, pickle.HIGHEST_PROTOCOL)
            told.flush()
    except (EOFError, pickle.UnpicklingError, BrokenPipeError, KeyboardInterrupt):  # whoever asked is gone
        return


if __name__ == "__main__":
    with kept_open():
        main()
