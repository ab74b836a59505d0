"""The smoother of followed motions: exact where the motion is a spline, honest about its error, blind to the clock."""

import numpy as np
import pytest
from realitygap.simulate.smooth import smooth
from realitygap.trace.trace import Array


def clock(samples: int = 1500, seed: int = 0, period: float = 0.01) -> Array:
    """Irregular stamps [s]."""
    return np.cumsum(np.random.default_rng(seed).uniform(0.5, 1.5, samples)) * period


def swing(time: Array) -> Array:
    """Two joints with their derivatives. Shape (3, t, 2)."""
    w = 2 * np.pi * np.array([0.5, 1.2])
    phase = time[:, None] * w
    return np.array([np.sin(phase), w * np.cos(phase), -(w**2) * np.sin(phase)])


def test_a_parabola_is_followed_to_rounding() -> None:
    time = clock(300)
    exact = np.array([1 + 2 * time - 3 * time**2, 2 - 6 * time, np.full_like(time, -6.0)])
    found = smooth(time, exact[0][:, None]).value[:, :, 0]
    np.testing.assert_allclose(found, exact, rtol=0, atol=1e-3)


@pytest.mark.parametrize("noise", [1e-4, 1e-3])
def test_the_error_that_is_told_covers_the_error_that_is_made(noise: float) -> None:
    """A swing is smoother than a jerk that is white noise, so that the error is told rather too large than too small;
    by less than a factor of four.
    """
    time = clock()
    exact = swing(time)
    reading = exact[0] + noise * np.random.default_rng(1).normal(size=exact[0].shape)
    found = smooth(time, reading)
    np.testing.assert_allclose(found.noise, noise, rtol=0.15)
    made = np.sqrt(np.mean((found.value - exact) ** 2, axis=1))
    told = np.sqrt(np.mean(found.error**2, axis=1))
    assert (made < 1.1 * told).all()
    assert (told < 4 * made).all()


def test_a_coarse_encoder_is_no_better_than_its_rounding() -> None:
    time, quantum = clock(), 1.5e-3
    exact = swing(time)
    found = smooth(time, np.round(exact[0] / quantum) * quantum)
    assert (found.noise >= quantum / np.sqrt(12) * 0.999).all()
    assert np.sqrt(np.mean((found.value[2] - exact[2]) ** 2, axis=0)).max() < 3.0


def test_more_noise_narrows_the_band() -> None:
    time = clock()
    rng = np.random.default_rng(2)
    bands = [smooth(time, swing(time)[0] + s * rng.normal(size=(len(time), 2))).bandwidth for s in (1e-5, 1e-4, 1e-3)]
    assert (np.diff(bands, axis=0) < 0).all()


def test_missing_readings_are_bridged() -> None:
    time = clock()
    exact = swing(time)
    reading = exact[0] + 1e-4 * np.random.default_rng(4).normal(size=exact[0].shape)
    reading[500:505] = np.nan
    found = smooth(time, reading)
    assert np.isfinite(found.value).all()
    assert np.abs(found.value[0] - exact[0]).max() < 2e-3
    assert (found.error[2, 502] > found.error[2, 400]).all()


@pytest.mark.parametrize("size", [1e3, 1e9, 1e15])
def test_an_expectation_that_runs_away_leaves_finite_differences(size: float) -> None:
    time, quantum = clock(), 1.5e-3
    expected = size * np.exp(-((time[:, None] - 8.0) ** 2)) * np.array([1.0, -1.0])
    expected[-2:] = np.inf
    found = smooth(time, np.round(swing(time)[0] / quantum) * quantum, around=expected)
    assert np.isfinite(found.value).all()
    assert np.isfinite(found.error).all()
    assert np.abs(found.value[0, :-2] + expected[:-2]).max() < 1e-3 * size + 2.0


def test_a_joint_that_does_not_move_has_no_derivatives() -> None:
    time = clock(100)
    found = smooth(time, np.full((100, 1), 0.7))
    assert found.value[0] == pytest.approx(0.7)
    assert not found.value[1:].any()
    assert found.bandwidth[0] == 0
