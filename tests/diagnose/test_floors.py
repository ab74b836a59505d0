"""The floors of samples, on the bundled demo (synthetic): numerics, noise and what disturbances explain of it."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from realitygap.diagnose.data.noise import local_maximum
from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.data.push import Push
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.data.worker import Query, answer
from realitygap.diagnose.likelihood.disturbance import disturbances, sensitivities, spread
from realitygap.diagnose.likelihood.floors import COARSE, FAITHFUL, NEIGHBOURS, Floors, measure
from signals import there


@pytest.fixture(scope="module")
def once(problem: Problem) -> Problem:
    """The motions that were recorded once: nothing tells of disturbances."""
    return replace(problem, cases=tuple(c for c in problem.cases if not c.spread))


@pytest.fixture(scope="module")
def floors(once: Problem) -> Floors:
    with Simulations(once, 1) as simulations:
        return measure(simulations, [])


def test_numerics_are_twice_what_half_the_step_moves_and_a_jump_of_the_effort(once: Problem, floors: Floors) -> None:
    """A step is of first order in its length: half of it halves the error. An effort is told before or after a jump."""
    assert once.cases
    for i, case in enumerate(once.cases):
        whole, half = (there(answer(once, Query((), i, "mujoco", finer))) for finer in (1.0, 2.0))
        for signal in ("position", "velocity", "effort"):
            off = 2.0 * local_maximum(np.abs(whole[signal] - half[signal]), NEIGHBOURS)
            if signal == "effort":
                assert case.experiment.commands.held
                jumps = there(answer(once, Query((), i, "mujoco", jumps=True)))["jump"]
                assert jumps.max() > 5.0 * np.median(off), "steps of the command"
                off = np.hypot(off, jumps)
            assert_allclose(floors.slow[i][signal], off, err_msg=signal)
            assert_allclose(floors.sigma(i, signal), np.hypot(off, case.noise[signal]))


def test_the_coarsest_step_that_is_faithful_is_taken(once: Problem, floors: Floors) -> None:
    for i, taken in enumerate(floors.coarse):
        whole, faithful = there(answer(once, Query((), i, "mujoco"))), []
        for share in COARSE:
            other = there(answer(once, Query((), i, "mujoco", share)))
            parts = [(other[s] - whole[s]) / floors.sigma(i, s) for s in once.signals(i)]
            faithful.append(np.sqrt(np.mean(np.concatenate([p.ravel() for p in parts]) ** 2)) <= FAITHFUL)
        assert taken == min([share for share, good in zip(COARSE, faithful, strict=True) if good], default=1.0)


@pytest.mark.parametrize("louder", [1.0, 100.0])
def test_noise_is_what_disturbances_leave_of_the_spread_and_no_less_than_the_sensors(
    problem: Problem, louder: float
) -> None:
    """Of the mean of repetitions: one over the root of their number."""
    white = [{s: louder * v for s, v in c.white.items()} for c in problem.cases]
    loud = replace(problem, cases=tuple(replace(c, white=w) for c, w in zip(problem.cases, white, strict=True)))
    every = range(len(loud.cases))
    with Simulations(loud, 2) as simulations:
        found = measure(simulations, [])
        moved = sensitivities(simulations, [], every)
    torque = disturbances(loud, moved)
    assert_allclose(found.torque, torque)
    repeated = [i for i in every if loud.cases[i].spread]
    for signal in ("position", "velocity", "effort"):
        own, seen, pushed = [], [], []
        for i in repeated:
            case = loud.cases[i]
            far = spread(case, moved[i], torque).get(signal, np.zeros((1, 2)))
            own.append(case.white[signal] ** 2)
            seen.append(case.spread[signal] ** 2)
            pushed.append(np.mean(far**2, axis=0) * case.repetitions)
        single = np.sqrt(np.maximum(np.mean(own, axis=0), np.mean(seen, axis=0) - np.mean(pushed, axis=0)))
        if not torque.any():
            single = np.sqrt(np.mean(seen, axis=0))
        for i in every:
            assert_allclose(found.noise[i][signal], single / np.sqrt(loud.cases[i].repetitions), rtol=1e-6)


def test_the_torque_that_repetitions_differ_by_is_what_moves_joints_as_far_as_they_do(problem: Problem) -> None:
    """√(spread² − white²) over how far 1 N·m moves that joint in root mean square, in the mean of repeated motions."""
    random, expected = np.random.default_rng(3), []
    moved: list[dict[int, dict[str, np.ndarray]]] = []
    for case in problem.cases:
        far = {j: {"position": random.uniform(0.1, 0.4 + j, case.value("position").shape)} for j in range(2)}
        moved.append(far)
        if case.repetitions > 1:
            excess = np.sqrt(np.maximum(case.spread["position"] ** 2 - case.white["position"] ** 2, 0.0))
            expected.append([excess[j] / np.sqrt(np.mean(far[j]["position"][:, j] ** 2)) for j in range(2)])
    assert_allclose(disturbances(problem, moved), np.mean(expected, axis=0))
    assert np.min(expected) >= 0.0
    assert np.max(expected) > 0.0


def test_a_torque_that_repetitions_were_planted_with_is_found(problem: Problem) -> None:
    """Simulated with a constant torque to either side: to half or double, as what comes and goes is asked too."""
    torque, cases = 0.2, []
    for i, case in enumerate(problem.cases):
        if case.repetitions > 1:
            ways = [
                there(answer(problem, Query((), i, "mujoco", push=Push(1, t))))["position"] for t in (-torque, torque)
            ]
            far = np.sqrt(np.mean(((ways[1] - ways[0]) / 2.0) ** 2, axis=0))
            case = replace(case, spread=case.spread | {"position": far}, white=case.white | {"position": 0.0 * far})
        cases.append(case)
    planted = replace(problem, cases=tuple(cases))
    with Simulations(planted, 2) as simulations:
        found = disturbances(planted, sensitivities(simulations, [], range(len(cases))))
    assert 0.5 * torque < found[1] < 2.0 * torque
