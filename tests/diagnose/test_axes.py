"""Slopes along the axes of a fit: those of each value alone where motions are smooth, steadier where they are rough."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from demo_problem import suspect_of
from realitygap.diagnose.candidates.starts import guess
from realitygap.diagnose.candidates.suspects import suspects
from realitygap.diagnose.data.changes import Change
from realitygap.diagnose.data.problem import Problem, build_problem
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.fit import fit as fit_module
from realitygap.diagnose.fit.axes import along_axes
from realitygap.diagnose.fit.fit import Fit, slope, stretched
from realitygap.diagnose.fit.motions import Motions, residual
from realitygap.diagnose.fit.responses import single
from realitygap.diagnose.fit.space import Space
from realitygap.diagnose.search.criterion import Criterion
from realitygap.robot.drive import Array
from realitygap.scenario.file import load_scenario

SCENARIOS = Path(__file__).parents[2] / "scenarios"


@pytest.fixture(scope="module")
def changes(problem: Problem) -> list[Change]:
    """First guesses of what could be missing at one joint of the demo."""
    names = ("coulomb_friction", "viscous_friction", "controller_gain")
    return [guess(problem, suspect_of(problem, n, "elbow")) for n in names]


def _fitted(criterion: Criterion, changes: Sequence[Change]) -> tuple[Fit, Any]:
    left = residual(criterion.simulations, changes, criterion.train)
    assert left is not None
    criterion.set_effective_fraction(left)
    found = Fit(tuple(changes), left)
    return found, criterion.plain(found).metric


def test_where_motions_are_smooth_they_are_those_of_each_value_alone(
    problem: Problem, simulations: Simulations, changes: list[Change]
) -> None:
    criterion = Criterion(simulations, [])
    found, metric = _fitted(criterion, changes)
    space = Space(problem, changes)
    alone = slope(criterion.motions, space, space.first)
    known = alone * np.array([1.3, 0.8, 1.1])  # what was known from near by is replaced
    told = along_axes(criterion.motions, space, space.first, found.residual, known, metric)
    white, own = metric(told), metric(alone)
    cosine = np.sum(white * own, 0) / np.linalg.norm(white, axis=0) / np.linalg.norm(own, axis=0)
    assert np.all(cosine > 0.95)
    assert np.linalg.norm(white, axis=0) == pytest.approx(np.linalg.norm(own, axis=0), rel=0.15)


@pytest.mark.usefixtures("data_dir")
def test_where_motions_are_rough_they_lead_the_same_way_from_the_same_place() -> None:
    """Of a humanoid whose shoulders have play: of the softest axis, at models that differ by nothing that counts."""
    problem = build_problem(load_scenario(SCENARIOS / "sigmaban" / "frictionless.yaml"), "mujoco")
    effects = ("coulomb_friction", "viscous_friction", "controller_gain")
    servos = [s for s in suspects(problem) if s.effect in effects and len(s.indices) == 10]
    shoulders = [suspect_of(problem, "backlash", f"{side}_shoulder_pitch") for side in ("left", "right")]
    with Simulations(problem, 2) as simulations:
        criterion = Criterion(simulations, [])
        likely = {"torque": 0.35, "coefficient": 0.4, "gain": 7.0, "angle": 0.01}
        starts = [guess(problem, s) for s in [*servos, *shoulders]]
        fitted = [start.at({n: likely[n] for n in start.free}) for start in starts]
        found, metric = _fitted(criterion, fitted)
        space, motions = Space(problem, fitted), criterion.motions
        known = slope(motions, space, space.first)
        softest = np.linalg.svd(metric(known * space.unit(space.first)), full_matrices=False)[2][-1]

        def softness(x: Array) -> tuple[Array, Array]:
            alone = slope(motions, space, x)
            axes = along_axes(motions, space, x, found.residual, known, metric)
            return metric(alone * space.unit(x)) @ softest, metric(axes * space.unit(x)) @ softest

        here = softness(space.first)
        there = [softness(space.first * (1.0 + moved)) for moved in (1e-6, -1e-6)]
        apart = [[np.linalg.norm(b - a) / np.linalg.norm(a) for a, b in zip(here, of, strict=True)] for of in there]
        alone, axes = np.mean(apart, axis=0)
        assert axes < 0.7 * alone


def test_a_fit_is_stretched_from_where_it_began_within_its_bounds(
    problem: Problem, simulations: Simulations, changes: list[Change]
) -> None:
    criterion = Criterion(simulations, [])
    friction = changes[0]
    (torque,) = (friction.parameters[n] for n in friction.free)
    left = residual(simulations, [friction], criterion.train)
    assert left is not None
    found = Fit((friction,), left, ((0, friction.free[0]),), np.zeros((len(left), 1)), np.ones(1), np.zeros(1))
    before = [friction.at({friction.free[0]: 0.9 * torque})]
    for times, expected in ((1.0, torque), (2.0, 1.1 * torque), (-20.0, 0.0)):
        far = stretched(criterion.motions, before, found, times)
        assert far is not None
        assert far.value[0] == pytest.approx(expected)
        anew = residual(simulations, far.changes, criterion.train)
        assert anew is not None
        assert far.residual == pytest.approx(anew, abs=0.05 * float(np.abs(anew).max()))


@pytest.mark.usefixtures("data_dir")
def test_a_step_that_failed_is_not_simulated_again(monkeypatch: pytest.MonkeyPatch) -> None:
    problem = build_problem(load_scenario(SCENARIOS / "so101" / "scenario.yaml"), "mujoco")
    tried: list[tuple[Change, ...]] = []
    simulated = fit_module.residual_near

    def noted(motions: Motions, near: Fit, changes: Sequence[Change]) -> Array | None:
        tried.append(tuple(changes))
        return simulated(motions, near, changes)

    with Simulations(problem, 1) as simulations:
        criterion = Criterion(simulations, [])
        gains = [guess(problem, s) for s in suspects(problem) if s.effect == "controller_gain" and single(s)]
        found, metric = _fitted(criterion, gains)
        monkeypatch.setattr(fit_module, "residual_near", noted)
        fit_module.fit(criterion.motions, gains, metric, found, "compared")
    assert len(tried) > 2
    assert len(set(tried)) == len(tried)
