"""The values of a fit as one vector: what priors say of them and how they are moved, and steps of least squares."""

import numpy as np
import pytest
from demo_problem import suspect_of
from realitygap.diagnose.candidates.starts import guess
from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.fit.fit import nearest
from realitygap.diagnose.fit.space import SLAB, TAIL, Space, negative_log_prior
from realitygap.robot.drive import Array

EFFECTS = {"coulomb_friction": "elbow", "controller_gain": "elbow", "joint_offset": "shoulder", "link_mass": "forearm"}


@pytest.fixture(scope="module")
def space(problem: Problem) -> Space:
    """Of a friction and an offset that the model has not, and a gain and a mass that it has."""
    return Space(problem, [guess(problem, suspect_of(problem, e, at)) for e, at in EFFECTS.items()])


def test_a_prior_is_normal_and_beyond_a_power_law_that_is_as_smooth() -> None:
    far = np.array([-1.0, 0.5, TAIL])
    np.testing.assert_allclose(negative_log_prior(far), far**2 / 2)
    assert negative_log_prior(np.array([-6.0])) == pytest.approx(TAIL**2 * (0.5 + np.log(6.0 / TAIL)))
    left, right = (np.diff(negative_log_prior(TAIL + np.array(d)))[0] for d in ((-1e-6, 0.0), (0.0, 1e-6)))
    assert left == pytest.approx(right, rel=1e-4)


@pytest.mark.parametrize("times", [0.05, 0.7, 1.0, 1.2, 4.0, 30.0])
def test_the_slope_of_a_prior_is_its_derivative(space: Space, times: float) -> None:
    x = np.where(space.positive, space.expected * times, times - 1.0)
    moves = enumerate(1e-6 * np.eye(len(x)))
    slope = np.array([(space.prior(x + d)[k] - space.prior(x - d)[k]) / 2e-6 for k, d in moves])
    np.testing.assert_allclose(space.prior_slope(x), slope, rtol=1e-4)
    white = np.zeros((3, len(x) + 1))
    unit = np.linspace(0.1, 0.4, len(x))
    rows = space.with_prior(x, white, unit)[3:]
    np.testing.assert_allclose(rows, np.column_stack([np.diag(slope * unit), space.prior(x)]), rtol=1e-4, atol=1e-12)


def test_a_tenth_of_what_is_there_is_as_odd_as_its_tenfold_and_an_offset_counts_in_widths(space: Space) -> None:
    there = np.flatnonzero(space.positive)
    assert len(there) >= 2
    less, more = (space.prior(space.expected * times)[there] for times in (0.1, 10.0))
    np.testing.assert_allclose(less, -more)
    assert np.all(more > 0.0)
    (offset,) = (k for k, (i, _) in enumerate(space.names) if space.changes[i].suspect.effect == "joint_offset")
    for widths in (-1.0, 0.5):
        x = space.expected.copy()
        x[offset] += widths * SLAB
        assert space.prior(x)[offset] == pytest.approx(widths)


def test_a_value_is_moved_by_a_part_of_itself_and_back_where_a_bound_is(space: Space) -> None:
    x = np.minimum(np.maximum(space.first, 0.01), space.bounds()[1])
    for k, (moved, step) in enumerate(space.steps(x)):
        assert step == pytest.approx(0.05 * max(abs(x[k]), 0.3))
        np.testing.assert_allclose(moved - x, step * np.eye(len(x))[k], atol=1e-12)
    bounded = np.isfinite(space.bounds()[1])
    at = np.where(bounded, space.bounds()[1], x)
    for k in np.flatnonzero(bounded).tolist():
        moved, step = space.steps(at)[k]
        assert step < 0.0
        assert moved[k] == pytest.approx(at[k] + step)


def test_the_nearest_step_is_that_of_least_squares_within_its_bounds() -> None:
    rng = np.random.default_rng(2)
    slopes, residual = rng.normal(size=(40, 3)), rng.normal(size=40)
    free, far = np.linalg.lstsq(slopes, -residual, rcond=None)[0], np.full(3, 10.0)
    white = np.column_stack([slopes, residual])
    np.testing.assert_allclose(nearest(white, -far, far), free, atol=1e-9)
    low: Array = np.array([-10.0, free[1] + 0.1, -10.0])
    held = nearest(white, low, far)
    others = np.linalg.lstsq(slopes[:, [0, 2]], -residual - slopes[:, 1] * low[1], rcond=None)[0]
    np.testing.assert_allclose(held, [others[0], low[1], others[1]], atol=1e-8)
