"""The likelihood: its closed forms, and what it says of noise that is known."""

from dataclasses import replace

import numpy as np
import pytest
from realitygap.diagnose.likelihood.channel_blocks import ChannelBlocks
from realitygap.diagnose.likelihood.excess import excess_deviation
from realitygap.diagnose.likelihood.metric import Metric, marginalised, trusted
from realitygap.diagnose.likelihood.whitening import Channel, Whitening, effective_fraction
from realitygap.robot.drive import Array


def channel(n: int, noise: float = 0.5, slow: float = 0.2, case: int = 0, signal: str = "position") -> Channel:
    return Channel(case, signal, 0, 0.01 * np.arange(n, dtype=np.float64), noise, np.full(n, slow))


def measured_by(watched: Channel, rest: float, residual: Array, responses: Array) -> Metric:
    """The metric for what a residual leaves, of one channel."""
    whitening, weight = trusted([watched], np.ones(1), np.full(1, rest), residual)
    white, half_log_det = whitening(responses, weight)
    return marginalised(whitening, weight, ChannelBlocks.of(white, whitening.number), half_log_det)


def test_the_length_under_a_metric_is_that_of_the_dense_covariance() -> None:
    """With a discrepancy marginalised: r'(V + Φ·s²·Φ')⁻¹r and its determinant, by the matrices themselves."""
    rng = np.random.default_rng(3)
    n, watched = 40, channel(40)
    residual, responses, scale = rng.standard_normal(n), rng.standard_normal((n, 3)), np.array([0.3, 1.0, 2.0])
    measure = measured_by(watched, 0.1, residual, responses * scale)
    variance = np.diag((watched.noise**2 + watched.slow**2 + 0.1**2) / measure.weight)
    dense = variance + (responses * scale**2) @ responses.T
    whole = measure(residual)
    assert whole @ whole == pytest.approx(residual @ np.linalg.solve(dense, residual))
    assert measure.half_log_det == pytest.approx(0.5 * np.linalg.slogdet(dense)[1])
    columns = rng.standard_normal((n, 2))
    several = np.column_stack([residual, columns])
    assert measure.gram([residual, columns]) == pytest.approx(several.T @ np.linalg.solve(dense, several))


def test_what_was_not_measured_counts_nothing() -> None:
    rng = np.random.default_rng(4)
    watched, residual = channel(30), rng.standard_normal(30)
    residual[10:20] = np.nan
    measure = measured_by(watched, 0.0, residual, np.zeros((30, 0)))
    assert np.all(measure(np.nan_to_num(residual, nan=7.0))[10:20] == 0.0)


def test_white_noise_counts_in_full_and_what_lasts_once() -> None:
    """An AR(1) series has the integrated autocorrelation time (1 + a)/(1 − a)."""
    rng = np.random.default_rng(5)
    n, keep = 20000, 0.9
    white = rng.standard_normal(n)
    lasting = np.empty(n)
    lasting[0] = white[0]
    for k in range(1, n):
        lasting[k] = keep * lasting[k - 1] + np.sqrt(1 - keep**2) * white[k]
    (one,), (few,) = effective_fraction([channel(n)], white), effective_fraction([channel(n)], lasting)
    assert one == pytest.approx(1.0)
    assert 1.0 / few == pytest.approx((1 + keep) / (1 - keep), rel=0.2)


def test_a_motion_in_which_a_channel_was_not_measured_tells_nothing_of_how_long_it_lasts() -> None:
    lasting = np.full(400, 3.0)
    (alone,) = effective_fraction([channel(400)], lasting)
    both = effective_fraction([channel(400), channel(400, case=1)], np.concatenate([lasting, np.full(400, np.nan)]))
    assert both == pytest.approx([alone, alone])


def test_a_constant_gap_is_no_mean_that_could_be_left_out() -> None:
    (few,) = effective_fraction([channel(400)], np.full(400, 3.0))
    assert few == pytest.approx(1 / 50)  # once in half a second


def test_the_rest_is_what_lies_beyond_the_floors() -> None:
    rng = np.random.default_rng(6)
    watched = [channel(20000, case=c) for c in range(2)]
    residual = rng.standard_normal(40000) * np.sqrt(0.5**2 + 0.2**2 + 0.7**2)
    assert excess_deviation(watched, np.ones(2), residual) == pytest.approx([0.7, 0.7], rel=0.03)
    assert not excess_deviation(watched, np.ones(2), 0.3 * residual).any()


def test_each_motion_has_an_excess_of_its_own_as_far_as_it_has_effective_samples() -> None:
    rng = np.random.default_rng(9)
    watched = [channel(20000, case=c) for c in range(2)]
    residual = rng.standard_normal(40000) * np.hypot(np.hypot(0.5, 0.2), np.repeat([0.1, 2.0], 20000))
    assert excess_deviation(watched, np.ones(2), residual) == pytest.approx([0.1, 2.0], rel=0.15)
    shared = excess_deviation(watched, np.full(2, 1e-6), residual)
    assert shared == pytest.approx(np.full(2, np.sqrt(0.5 * (0.1**2 + 2.0**2))), rel=0.1)


def test_a_high_floor_somewhere_hides_no_rest_elsewhere() -> None:
    """As in a throw: the flight is exact to the sensor, and after the contact half a step decides where it goes."""
    rng = np.random.default_rng(8)
    slow = np.where(np.arange(20000) < 10000, 1e-3, 50.0)
    watched = replace(channel(20000, noise=1e-3), slow=slow)
    residual = 0.7 * rng.standard_normal(20000)
    assert excess_deviation([watched], np.ones(1), residual) == pytest.approx([0.7], rel=0.5)


def test_a_sample_beyond_three_of_the_others_is_trusted_by_half_and_less() -> None:
    """The weight of a Cauchy likelihood, 1/(1 + (r/3σ)²), σ being what all of them have in the mean."""
    residual = np.random.default_rng(11).standard_normal(400)
    residual[[7, 200]] = 9.0, -25.0
    _, weight = trusted([channel(400)], np.ones(1), np.zeros(1), residual)
    np.testing.assert_allclose(weight, 1.0 / (1.0 + residual**2 / (9.0 * np.mean(residual**2))))
    assert weight[200] < weight[7] < 0.5 < weight[np.abs(residual) < 1.0].min()


def test_samples_that_are_not_looked_at_are_said_by_those_that_are() -> None:
    """Of a residual that lasts, as long as it is: every tenth sample stands for ten, at the same likelihood."""
    n, fraction = 400, 1.0 / 40.0
    whitening = Whitening((channel(n),), np.zeros(1), np.full(1, fraction))
    assert len(whitening.rows) == 40
    white, half_log_det = whitening(np.full((n, 1), 0.7), np.ones(n))
    variance = 0.5**2 + 0.2**2
    assert np.sum(white**2) == pytest.approx(n * fraction * 0.7**2 / variance)
    assert half_log_det == pytest.approx(0.5 * n * fraction * np.log(variance))


def test_what_no_law_explains_elsewhere_is_the_mean_square_of_the_channel() -> None:
    """Of a motion that was not looked at; one that was has its own."""
    known = tuple(channel(10, case=c) for c in range(2))
    whitening = Whitening(known, np.array([0.3, 0.4]), np.full(2, 0.5))
    other = whitening.elsewhere([channel(10, case=7), channel(10, case=1)])
    assert other.excess == pytest.approx([np.sqrt(0.5 * (0.3**2 + 0.4**2)), 0.4])
    assert other.effective_fraction == pytest.approx([0.5, 0.5])


def test_a_change_is_seen_in_all_samples_together() -> None:
    """So many standard deviations as their squares add up to, were laws exact."""
    measure = measured_by(channel(40), 0.0, np.zeros(40), np.ones((40, 1)))
    assert measure.seen(np.full(40, 0.1)) == pytest.approx(np.sqrt(40) * 0.1 / np.hypot(0.5, 0.2))


def test_a_fact_scales_the_likelihood_and_nothing_else() -> None:
    residual = np.random.default_rng(7).standard_normal((50, 1))
    (full, half_log_det), (half, less) = (
        Whitening((channel(50),), np.zeros(1), np.full(1, share))(residual, np.ones(50)) for share in (1.0, 0.5)
    )
    assert half == pytest.approx(np.sqrt(0.5) * full)
    assert less == pytest.approx(0.5 * half_log_det)


def test_columns_that_are_zero_elsewhere_multiply_as_the_whole_matrix() -> None:
    """Three channels, of which columns are zero in some: every product is that of the dense matrix."""
    rng = np.random.default_rng(9)
    sizes, rows = [7, 5, 9], np.repeat([0, 1, 2], [7, 5, 9])
    seen = np.array([[1, 0, 1, 0], [0, 1, 1, 0], [0, 0, 1, 1]], dtype=bool)
    dense = rng.standard_normal((21, 4)) * seen[rows]
    scale, columns, amounts, others = (rng.standard_normal(s) for s in (21, 4, (4, 2), (21, 3)))
    blocks = ChannelBlocks.of(dense, sizes)
    assert [len(p.columns) for p in blocks.blocks] == [2, 2, 2]
    assert blocks.gram() == pytest.approx(dense.T @ dense)
    assert blocks.on(others) == pytest.approx(dense.T @ others)
    assert blocks.times(amounts) == pytest.approx(dense @ amounts)
    assert blocks.scaled(scale).times(np.eye(4)) == pytest.approx(dense * scale[:, None])
    assert blocks.stretched(columns).times(np.eye(4)) == pytest.approx(dense * columns)
    assert blocks.beside(blocks).times(np.eye(8)) == pytest.approx(np.hstack([dense, dense]))
    strides = [2, 1, 4]
    few = np.concatenate([np.flatnonzero(rows == c)[::s] for c, s in enumerate(strides)])
    assert blocks.every(strides).times(np.eye(4)) == pytest.approx(dense[few])
