"""Where a model and recordings part: the floors that are told are those that the gap was weighed against."""

from dataclasses import replace

import numpy as np
import pytest
from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.judge.locate import Place, locate, phases
from realitygap.diagnose.judge.worsened import in_units, worsened
from realitygap.diagnose.likelihood.floors import Floors, measure
from realitygap.robot.drive import DC, DUTY, EFFORT, PID, POSITION, SPEED, VELOCITY

UNSURE = 1e3
"""Floor of a few samples, in the largest gap: as where a held command jumps."""


@pytest.fixture(scope="module")
def found(simulations: Simulations) -> tuple[Floors, list[Place], list[Place]]:
    """Where the demo's own model is off, and the same where every thirtieth sample says nothing."""
    problem, floors = simulations.problem, measure(simulations, [])
    simulated = {i: a for i, a in enumerate(simulations.of([], range(len(problem.cases)))) if a is not None}
    return floors, locate(problem, floors, simulated), locate(problem, _spoiled(problem, floors, simulated), simulated)


def _spoiled(problem: Problem, floors: Floors, simulated: dict[int, dict[str, np.ndarray]]) -> Floors:
    slow = []
    for i, signals in enumerate(floors.slow):
        slow.append({s: v.copy() for s, v in signals.items()})
        for s, v in slow[-1].items():
            v[::30] = UNSURE * np.abs(simulated[i][s] - problem.cases[i].value(s)).max()
    return replace(floors, slow=tuple(slow))


def test_a_gap_is_as_many_floors_as_are_told(found: tuple[Floors, list[Place], list[Place]]) -> None:
    for places in found[1:]:
        assert len(places) > 2
        for p in places:
            assert p.floors * np.hypot(p.noise_floor, p.numerical_floor) == pytest.approx(p.gap)
            assert np.hypot(p.noise_floor, p.numerical_floor) < p.gap


def test_a_few_unsure_samples_do_not_rule_the_floor(found: tuple[Floors, list[Place], list[Place]]) -> None:
    sure = {(p.joint, p.signal): p for p in found[1]}
    for p in found[2]:
        assert p.numerical_floor < sure[p.joint, p.signal].numerical_floor * 1.2 + 0.2 * p.noise_floor


def test_of_even_floors_the_noise_told_is_the_mean_absolute_noise(simulations: Simulations) -> None:
    """Where the difference is as random as the noise: its mean absolute value is the floor, 0.8 standard deviations."""
    problem, floors, random = simulations.problem, measure(simulations, []), np.random.default_rng(0)
    even = replace(floors, slow=tuple({s: np.zeros_like(v) for s, v in d.items()} for d in floors.slow))
    simulated = {
        i: {s: c.value(s) + 2 * n * random.standard_normal(c.value(s).shape) for s, n in even.noise[i].items()}
        for i, c in enumerate(problem.cases)
    }
    places = locate(problem, even, simulated)
    assert len(places) == 6
    for p in places:
        j = problem.plant.model.joint_names.index(p.joint)
        scale = 1.0 if p.signal == "effort" else 180 / np.pi
        sigma = np.sqrt(np.mean([even.noise[i][p.signal][j] ** 2 for i in range(len(problem.cases))]))
        assert p.noise_floor == pytest.approx(np.sqrt(2 / np.pi) * sigma * scale, rel=0.05)
        assert p.numerical_floor == pytest.approx(0.0, abs=1e-9)


def test_a_motion_without_effort_is_never_loaded_beside_others_that_are(simulations: Simulations) -> None:
    """As an arm that was let go, beside motions that efforts drove."""
    problem, floors = simulations.problem, measure(simulations, [])
    simulated = {i: a for i, a in enumerate(simulations.of([], range(len(problem.cases)))) if a is not None}
    simulated[0] = simulated[0] | {"effort": np.zeros_like(simulated[0]["effort"])}
    assert len(locate(problem, floors, simulated)) > 2
    assert not [p for p in locate(problem, floors, {0: simulated[0]}) if "loaded" in p.when]


def _unmeasured(problem: Problem) -> Problem:
    """The motions in which the velocity of the elbow was never told, as of an interface that is not there."""
    cases = []
    for case in problem.cases:
        velocity = case.value("velocity").copy()
        velocity[:, 1] = np.nan
        cases.append(replace(case, measured=replace(case.measured, velocity=velocity)))
    return replace(problem, cases=tuple(cases))


def test_a_joint_that_was_not_measured_takes_no_number_from_the_others(
    simulations: Simulations, found: tuple[Floors, list[Place], list[Place]]
) -> None:
    problem, floors = simulations.problem, found[0]
    simulated = {i: a for i, a in enumerate(simulations.of([], range(len(problem.cases)))) if a is not None}
    part, judge = _unmeasured(problem), problem.of("held_out")
    places = [p for p in locate(part, floors, simulated) if p.signal == "velocity"]
    assert places == [p for p in found[1] if p.signal == "velocity" and p.joint == "shoulder"]
    (told,) = (u for u in in_units(part, judge, simulated, simulated) if u.signal == "velocity")
    assert np.isfinite(told.before)
    off = {i: {s: v + 1.0 for s, v in of.items()} for i, of in simulated.items()}
    assert ("elbow", "velocity") not in {(w.joint, w.signal) for w in worsened(part, floors, judge, simulated, off)}


@pytest.mark.parametrize(
    ("kind", "meaning", "gain", "command", "effort", "share"),
    [
        (DC, POSITION, 5.0, 1.0, 0.1, 1.0),
        (DC, POSITION, 0.5, 1.0, 0.1, 0.0),
        (DC, DUTY, 5.0, 1.0, 0.1, 1.0),
        (DC, DUTY, 5.0, 0.5, 0.1, 0.0),
        (PID, POSITION, 0.0, 1.0, 1.5, 1.0),
        (PID, POSITION, 0.0, 1.0, 0.5, 0.0),
        (PID, EFFORT, 0.0, 5.0, 1.4, 0.0),
        (SPEED, VELOCITY, 2.0, 3.0, -1.5, 1.0),
        (SPEED, VELOCITY, 2.0, 3.0, 1.2, 0.0),
    ],
)
def test_a_servo_gives_all_it_can_by_its_own_limit(
    simulations: Simulations, kind: int, meaning: int, gain: float, command: float, effort: float, share: float
) -> None:
    """By its duty, which 0.96 bounds, where that is what it gives, and by its effort of 1.5 N·m elsewhere."""
    case = simulations.problem.cases[0]
    plant = case.experiment.plant.copy()
    for name, value in {"kind": kind, "meaning": meaning, "gain": gain}.items():
        plant.drive[name] = value
    plant.drive["duty_limit"], plant.drive["effort_limit"] = 0.96, 1.5
    told = np.full_like(case.value("position"), command)
    here = replace(
        case, experiment=replace(case.experiment, plant=plant), measured=replace(case.measured, command=told)
    )
    still = {"position": np.zeros_like(told), "effort": np.full_like(told, effort)}
    assert np.mean(phases(here, 0, still)["saturation"]) == share
