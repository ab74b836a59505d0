"""A scenario mended by changes of one's choice, and whether it moves as the changed model did."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from realitygap.diagnose.data.changes import Change, Suspect
from realitygap.diagnose.data.problem import Problem, build_problem
from realitygap.diagnose.data.worker import Query, answer
from realitygap.diagnose.result.revise import write_revised
from realitygap.robot.effects import EFFECTS
from realitygap.robot.effects.place import targets
from realitygap.scenario.file import ScenarioFile, load_scenario

Wanted = tuple[str, str, Mapping[str, Any]]


def change(problem: Problem, effect: str, target: str, **values: float) -> Change:
    """An effect with values at a target."""
    indices = targets(problem.plant, EFFECTS[effect], target)
    return Change(Suspect(effect, target, tuple(indices)), tuple(values.items()))


def mended(scenario: Path, changes: Sequence[Wanted], out: Path) -> tuple[Problem, list[Change], ScenarioFile]:
    """The problem, its changes, and the mended scenario."""
    problem = build_problem(load_scenario(scenario), "mujoco")
    wanted = [change(problem, effect, target, **values) for effect, target, values in changes]
    return problem, wanted, load_scenario(write_revised(problem, wanted, out / "revised")[0])


def assert_same(problem: Problem, changes: Sequence[Change], revised: ScenarioFile) -> None:
    """Every run of the mended scenario moves as the changed model did."""
    again = build_problem(revised, "mujoco")
    assert [c.name for c in again.cases] == [c.name for c in problem.cases]
    every = range(len(problem.cases))
    for i in every:
        theirs, ours, base = (
            answer(p, Query(tuple(c), i, "mujoco")) for p, c in ((problem, changes), (again, ()), (problem, ()))
        )
        assert theirs is not None
        assert ours is not None
        assert base is not None
        for signal, value in theirs.items():
            np.testing.assert_allclose(ours[signal], value, rtol=0, atol=1e-7, err_msg=f"{signal} of case {i}")
        if changes:  # the change is one that shows
            noise = problem.cases[i].noise
            assert max(np.abs((value - base[s]) / noise[s]).max() for s, value in theirs.items()) > 0.01
