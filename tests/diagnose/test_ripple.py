"""Periods of a ripple are told from the residual over the angle, as far as its samples resolve them."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from demo_problem import suspect_of
from realitygap.diagnose.candidates.ripple import ORDINARY, PEAKS, periods_of, power, resolved
from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.fit.demanded import demanded
from realitygap.diagnose.fit.fit import Fit
from realitygap.diagnose.search.criterion import Criterion
from realitygap.robot.drive import Array
from realitygap.robot.effects import EFFECTS
from realitygap.scenario.schema import EffectSpec
from recorded_joint import recorded

TIME = np.arange(0.0, 8.0, 0.002)


def swinging(size: float, middle: float = 0.0) -> np.ndarray:
    """A motion that stays within 1.3 sizes of its middle and seldom returns on its way."""
    return middle + size * (0.8 * np.sin(1.3 * TIME) * np.cos(0.37 * TIME) + 0.5 * np.sin(0.7 * TIME))


def noise(seed: int, signals: int = 2) -> np.ndarray:
    return np.random.default_rng(seed).normal(0.0, 1.0, (len(TIME), signals))


@pytest.mark.parametrize(("size", "middle"), [(0.1, 0.0), (1.0, 2.0), (6.0, -1.0)])
def test_the_power_is_what_least_squares_says(size: float, middle: float) -> None:
    angle, residual = swinging(size, middle), noise(1) + swinging(1.0)[:, None]
    grid: Array = 0.25 * np.arange(4.0, 800.0)
    found = power(angle, residual, grid)
    for k in (40, 120, 300):  # waves that a bin does not blur
        line = np.column_stack([np.ones(len(angle)), angle])
        wave = np.column_stack([line, np.sin(grid[k] * angle), np.cos(grid[k] * angle)])
        left = [np.sum((residual - m @ np.linalg.lstsq(m, residual, rcond=None)[0]) ** 2, axis=0) for m in (line, wave)]
        np.testing.assert_allclose(found[k] * left[0], left[0] - left[1], rtol=0.05, atol=0.5)


def test_a_motion_that_is_far_off_for_another_cause_hides_no_ripple() -> None:
    quiet, far = swinging(1.0), swinging(0.7, 0.2)
    ripple = 2.0 * np.sin(24.0 * quiet)[:, None] * np.array([0.3, 1.0]) + noise(5)
    other = 60.0 * np.sign(np.sin(3.1 * TIME))[:, None] + noise(6)
    assert min(abs(p - 24.0) for p in periods_of([quiet, far], [ripple, other], ORDINARY)[:1]) < 0.3


@pytest.mark.parametrize(
    ("size", "periods"),
    [(0.3, 20.0), (0.3, 58.0), (0.3, 628.3), (1.0, 6.0), (1.0, 333.3), (1.0, 1200.0), (12.0, 4.5), (12.0, 100.0)],
)
def test_a_period_is_found_as_far_as_the_samples_resolve_it(size: float, periods: float) -> None:
    angle = swinging(size)
    residual = noise(2) + np.array([0.5, 0.0]) * np.sin(periods * angle + 0.4)[:, None]
    found = np.array(periods_of([angle, angle[::-1]], [residual, residual[::-1]], 2000.0))
    near = np.abs(found - periods) < np.pi / np.ptp(angle)
    assert near.any() == (periods < resolved(angle))


def test_several_motions_tell_together_what_none_tells_alone() -> None:
    angles = [swinging(0.2 + 0.02 * k) for k in range(8)]
    residuals = [noise(10 + k) + 0.13 * np.sin(300.0 * a)[:, None] for k, a in enumerate(angles)]
    assert any(abs(p - 300.0) < 10.0 for p in periods_of(angles, residuals, 2000.0))


@pytest.mark.parametrize("kind", ["noise", "slow", "turning"])
def test_chance_seldom_has_a_period_beyond_the_ordinary(kind: str) -> None:
    angle = swinging(0.5)
    tried = 0
    for seed in range(60):
        residual = noise(seed)
        if kind == "slow":
            residual = np.cumsum(residual, axis=0)
        if kind == "turning":
            residual += 5.0 * np.sign(np.gradient(angle))[:, None]
        found = periods_of([angle], [residual], 2000.0)
        assert 0 < len(found) <= 2 * PEAKS
        tried += sum(p > ORDINARY for p in found)
    assert tried <= 4  # of 60, 0.6 are expected


def test_what_was_not_measured_or_does_not_move_tells_nothing() -> None:
    angle, residual = swinging(1.0), noise(3)
    assert periods_of([np.full(len(TIME), 0.3)], [residual], 2000.0) == []
    assert periods_of([angle], [np.full_like(residual, np.nan)], 2000.0) == []
    residual += np.sin(40.0 * angle)[:, None]
    angle[::3], residual[1::3] = np.nan, np.nan
    assert abs(periods_of([angle], [residual], 2000.0)[0] - 40.0) < 0.5


@pytest.mark.parametrize(("size", "periods"), [(0.05, 2.0), (0.3, 5.0), (1.0, 1.5)])
def test_a_wave_that_never_comes_back_is_none(size: float, periods: float) -> None:
    """A slow change with the angle has no period that a motion saw; periods that are told it saw once at least."""
    angle = swinging(size)
    assert periods * np.ptp(angle) < 2.0 * np.pi
    found = periods_of([angle], [noise(4) + 3.0 * np.sin(periods * angle)[:, None]], 2000.0)
    assert all(p * np.ptp(angle) >= 2.0 * np.pi for p in found)


def test_a_joint_that_hardly_moves_shows_no_ordinary_period() -> None:
    angle = swinging(0.02)
    assert np.ptp(angle) * ORDINARY < 2.0 * np.pi
    assert periods_of([angle], [noise(4)], ORDINARY) == []


@pytest.mark.parametrize("name", ["friction_ripple", "torque_ripple"])
def test_a_ripple_is_none_where_no_motion_saw_a_period_of_it(name: str, problem: Problem) -> None:
    effect, plant = EFFECTS[name], problem.plant
    assert plant.travelled is not None
    elbow = plant.model.joint_names.index("elbow")
    least = 2.0 * np.pi / plant.travelled[elbow]
    first = effect.first_size(plant, elbow)
    assert first["periods"] >= 2.0 * least
    assert effect.absurd is not None
    assert effect.absurd(plant, elbow, first | {"periods": 1.01 * least}) is None
    assert "no motion saw one" in (effect.absurd(plant, elbow, first | {"periods": 0.99 * least}) or "")
    train = [problem.cases[c].value("position")[:, elbow] for c in problem.of("train")]
    assert plant.travelled[elbow] == max(np.ptp(a[np.isfinite(a)]) for a in train)
    plant = replace(plant, travelled=None)
    assert effect.absurd(plant, elbow, first | {"periods": 0.5}) is None


def test_a_ripple_of_a_motor_that_is_told_torques_shows_in_the_acceleration(tmp_path: Path) -> None:
    """Angles and speeds drift away from where nothing leads the joint back, and tell slow waves."""
    servo = {"kind": "effort", "armature": 0.2, "friction": {"coulomb": 0.2, "viscous": 0.5}}
    ripple = EffectSpec(effect="torque_ripple", target="*", amplitude=0.6, periods=11.0, phase=0.4)
    problem = recorded(tmp_path, servo, ripple)
    problem = replace(problem, cases=tuple(replace(c, noise=_without_effort(c.noise)) for c in problem.cases))
    with Simulations(problem, 2) as simulations:
        criterion = Criterion(simulations, [])
        nothing = Fit((), demanded(simulations, (), criterion.train))
        blocks = criterion.responses(nothing, [suspect_of(problem, "torque_ripple", "lift")])
    assert min(abs(b.start.tries[0].parameters["periods"] - 11.0) for b in blocks) < 0.5


def _without_effort(noise: dict[str, Array]) -> dict[str, Array]:
    return {signal: value for signal, value in noise.items() if signal != "effort"}
