"""Position, velocity and acceleration of a measured motion: the one smoother for motions that are followed.

A joint's jerk is taken as white noise and its reading as the position plus white noise; the mean of the motion, given
all readings, is the quintic smoothing spline (Wahba 1990, Spline Models for Observational Data, chapter 1), computed by
Kalman's filter and the backward pass of Rauch, Tung and Striebel (AIAA J. 3(8), 1965), for any spacing of the samples.

Its one free number per joint, the bandwidth, is the one that makes the readings most likely (Wecker, Ansley 1983, J.
Am. Stat. Assoc. 78), with a noise that is not below the rounding of the sensor, quantum/√12. The standard error of
all three, given the readings, comes out beside them. It is that of a jerk that is as white everywhere; where a motion
begins and ends it is not, and the acceleration is off by more: by how much, twice the bandwidth tells.
"""
# mypy: allow-untyped-defs
# (the compiled functions take arrays and numbers only; their callers are typed)

from dataclasses import dataclass

import numpy as np
from realitygap_engines.law.compiled import compiled
from scipy.optimize import minimize_scalar

from realitygap.recording.quantum import quantum
from realitygap.trace.trace import Array

TOLERANCE = 0.02
"""Of the logarithm of the bandwidth: the acceleration's error changes by a twentieth."""
FEWEST = 4
"""Readings below which a joint's derivatives are not told."""
EXPECTED = {1: 3.0625, 2: 4.75}
"""Mean square by which twice the bandwidth moves the velocity and the acceleration, in squares of its standard error,
where the jerk is white: ∫u²ᵏ·(K(u/2) − K(u))²·(1 + u⁻⁶)du over ∫u²ᵏ·K(u)du for the k-th derivative, with the spline's
kernel K(u) = 1/(1 + u⁶)."""
MISSED = {1: 1.469, 2: 3.134}
"""Mean square of what the smoother takes away of either, over that of what twice the bandwidth gives back:
∫u²ᵏ⁻⁶·(1 − K(u))²du over ∫u²ᵏ⁻⁶·(K(u/2) − K(u))²du."""
SURELY = 2.6
"""Over one period at the bandwidth that is known as well as three normal numbers tell: what is expected is exceeded by
so much in one of twenty (chi-square)."""
FINEST = 1e-7
"""What of their range readings are not told better than, whatever their quantum: the filter starts vague, and forgets
its start by differences of squares in double precision."""


@dataclass(frozen=True)
class Smoothed:
    """A motion with its derivatives.

    Attributes:
        time: of the readings [s]. Shape (t,).
        value: position, velocity and acceleration [rad, rad/s, rad/s² or m]. Shape (3, t, n).
        error: their standard errors. Shape (3, t, n).
        bandwidth: at which half of a sine's amplitude is left [Hz]; 0 where a joint does not move. Shape (n,).
        noise: of a reading [rad or m]. Shape (n,).
    """

    time: Array
    value: Array
    error: Array
    bandwidth: Array
    noise: Array


def smooth(time: Array, position: Array, *, around: Array | None = None) -> Smoothed:
    """The motion that readings (t, n) at increasing times (t,) tell; NaN is a reading that is missing.

    Args:
        time: of the readings [s].
        position: the readings [rad or m].
        around: a motion (t, n) that is expected; what is smoothed and told is how the readings differ from it,
            where it is finite.
    """
    n = position.shape[1]
    out = Smoothed(time, np.zeros((3, *position.shape)), np.zeros((3, *position.shape)), np.zeros(n), np.zeros(n))
    step = float(np.median(np.diff(time)))
    rounding = quantum(position) / np.sqrt(12.0)
    if around is not None:
        position = position - around
    for j in range(n):
        reading = position[:, j]
        known = np.isfinite(reading)
        if known.sum() < FEWEST or not np.ptp(reading[known]) > 0:
            out.value[0, :, j] = np.nanmean(reading) if known.any() else np.nan
            continue
        reading, middle = np.where(known, reading, np.nan), float(np.mean(reading[known]))
        unit = max(float(rounding[j]), float(np.ptp(reading[known])) * FINEST)
        counts = (reading - middle) / unit
        rate, noise = _likeliest(time, counts, step)
        value, spread = _smooth(time, counts, _jerk(rate, step) * noise**2, noise**2)
        wide, _ = _smooth(time, counts, _jerk(2.0 * rate, step) * noise**2, noise**2)
        for k in EXPECTED:
            spread[k] += _missed(k, wide[k] - value[k], spread[k], 2 * np.pi / (rate * step))
        out.value[:, :, j], out.error[:, :, j] = value * unit, np.sqrt(spread) * unit
        out.value[0, :, j] += middle
        out.bandwidth[j], out.noise[j] = rate / (2 * np.pi), noise * unit
    return out


def _jerk(rate: float, step: float) -> float:
    """The intensity of the jerk, for readings of unit noise, at which the spline passes half of a sine of this rate
    [rad/s]: 1/(1 + step·ω⁶/jerk), the equivalent kernel of regular samples (Silverman 1984, Ann. Stat. 12(3)).
    """
    return step * rate**6


def _likeliest(time: Array, reading: Array, step: float) -> tuple[float, float]:
    """The rate [rad/s] and the noise that make the readings most likely; the noise is at least their unit."""
    bounds = np.log(2 * np.pi / (time[-1] - time[0])), np.log(np.pi / step)

    def free(log_rate: float) -> float:
        log_s, misfit, count = _innovations(time, reading, _jerk(np.exp(log_rate), step))
        return float(log_s + count * np.log(misfit / count))

    def bounded(log_rate: float) -> float:
        log_s, misfit, _ = _innovations(time, reading, _jerk(np.exp(log_rate), step))
        return float(log_s + misfit)

    best = minimize_scalar(free, bounds=bounds, method="bounded", options={"xatol": TOLERANCE}).x
    _, misfit, count = _innovations(time, reading, _jerk(np.exp(best), step))
    noise = float(np.sqrt(misfit / count))
    if noise < 1.0:
        best = minimize_scalar(bounded, bounds=bounds, method="bounded", options={"xatol": TOLERANCE}).x
        noise = 1.0
    return float(np.exp(best)), noise


def _missed(order: int, moved: Array, spread: Array, samples: float) -> Array:
    """The mean square by which a derivative is off beyond its variance `spread`, around every sample. Shape (t,).

    Args:
        order: 1 for the velocity, 2 for the acceleration.
        moved: by how much twice the bandwidth moves it.
        spread: its variance.
        samples: of one period at the bandwidth, over which the mean is taken.
    """
    near = np.ones(min(max(int(samples), 1), len(moved)))
    mean = np.convolve(moved**2, near, "same") / np.convolve(np.ones(len(moved)), near, "same")
    expected = EXPECTED[order] * spread
    return np.where(mean > SURELY * expected, MISSED[order] * (mean - expected), 0.0)


@compiled
def _predict(x, p, h, jerk):
    """State and covariance a time h later."""
    a = h * h / 2
    x[0] += h * x[1] + a * x[2]
    x[1] += h * x[2]
    for k in range(3):
        p[0, k] += h * p[1, k] + a * p[2, k]
        p[1, k] += h * p[2, k]
    for k in range(3):
        p[k, 0] += h * p[k, 1] + a * p[k, 2]
        p[k, 1] += h * p[k, 2]
    h2, h3 = h * h, h * h * h
    p[0, 0] += jerk * h2 * h3 / 20
    p[1, 1] += jerk * h3 / 3
    p[2, 2] += jerk * h
    for i, j, q in ((0, 1, h2 * h2 / 8), (0, 2, h3 / 6), (1, 2, h2 / 2)):
        p[i, j] += jerk * q
        p[j, i] += jerk * q


@compiled
def _update(x, p, reading, noise):
    """Take over a reading of variance `noise`; the innovation and its variance."""
    s = p[0, 0] + noise
    innovation = reading - x[0]
    g = p[:, 0] / s
    for i in range(3):
        x[i] += g[i] * innovation
    row = p[0].copy()
    for i in range(3):
        for j in range(3):
            p[i, j] -= g[i] * row[j]
    for i in range(3):
        for j in range(i):
            p[i, j] = p[j, i] = 0.5 * (p[i, j] + p[j, i])
    return innovation, s


@compiled
def _begin(time, reading):
    """Where the filter starts: at the first reading, with velocities and accelerations as large as any difference."""
    x, p = np.zeros(3), np.zeros((3, 3))
    fastest, sharpest, before = 0.0, 0.0, -1
    for k in range(len(time)):
        if np.isnan(reading[k]):
            continue
        if before < 0:
            x[0] = reading[k]
        else:
            h = time[k] - time[before]
            fastest = max(fastest, abs(reading[k] - reading[before]) / h)
            sharpest = max(sharpest, fastest / h)
        before = k
    p[0, 0], p[1, 1], p[2, 2] = (np.nanmax(reading) - np.nanmin(reading)) ** 2, fastest**2, sharpest**2
    return x, p


@compiled
def _innovations(time, reading, jerk):
    """For readings of unit noise: Σ log of the innovations' variances, Σ innovation²/variance, and how many."""
    x, p = _begin(time, reading)
    log_s, misfit, count = 0.0, 0.0, 0
    for k in range(len(time)):
        if k:
            _predict(x, p, time[k] - time[k - 1], jerk)
        if not np.isnan(reading[k]):
            innovation, s = _update(x, p, reading[k], 1.0)
            if count >= 3:  # the first three tell where it starts
                log_s += np.log(s)
                misfit += innovation * innovation / s
            count += 1
    return log_s, misfit, count - 3


@compiled
def _smooth(time, reading, jerk, noise):
    """Mean and variance of position, velocity and acceleration, given all readings. Shapes (3, t)."""
    n = len(time)
    ahead, wide = np.empty((n, 3)), np.empty((n, 3, 3))  # before the reading
    here, narrow = np.empty((n, 3)), np.empty((n, 3, 3))  # after it
    x, p = _begin(time, reading)
    for k in range(n):
        if k:
            _predict(x, p, time[k] - time[k - 1], jerk)
        ahead[k], wide[k] = x, p
        if not np.isnan(reading[k]):
            _update(x, p, reading[k], noise)
        here[k], narrow[k] = x, p
    value, spread = np.empty((3, n)), np.empty((3, n))
    for k in range(n - 1, -1, -1):
        if k < n - 1:
            h = time[k + 1] - time[k]
            f = np.array([[1.0, h, h * h / 2], [0.0, 1.0, h], [0.0, 0.0, 1.0]])
            gain = np.linalg.solve(wide[k + 1], f @ narrow[k]).T
            x = here[k] + gain @ (x - ahead[k + 1])
            p = narrow[k] + gain @ (p - wide[k + 1]) @ gain.T
        value[:, k] = x
        for i in range(3):
            spread[i, k] = max(p[i, i], 0.0)
    return value, spread
