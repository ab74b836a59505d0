"""How far apart the clocks of two runs of one motion are, from their commands."""

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, next_fast_len, rfft
from scipy.optimize import minimize_scalar

from realitygap.recording.commands import held_at
from realitygap.recording.recording import Recording
from realitygap.trace.trace import Array

Mask = NDArray[np.bool_]
MOVING = np.radians(0.5)
"""A joint whose command ranges over more than this is moving [rad]."""


def delay(reference: Recording, other: Recording) -> float:
    """The time [s] by which the other run's command comes later, each on its own clock; 0 where nothing is commanded.

    The delay with the least mean squared difference of the commands over the time that both have, at least half of the
    shorter one: for all delays by cross-correlation through the Fourier transform, then refined below the sampling
    step. Of several equally good ones, as in a periodic motion, the smallest is taken.
    """
    if not reference.command.size or not other.command.size:
        return 0.0
    moving = moving_commands(reference) & moving_commands(other)
    if not moving.any():
        return 0.0
    step = 0.5 * min(float(np.median(np.diff(r.command_time))) for r in (reference, other))
    a, b = _sampled(reference, moving, step), _sampled(other, moving, step)
    error, lags = mean_squared_difference(a, b)
    inner = error[1:-1]
    valley = np.flatnonzero((inner <= error[:-2]) & (inner <= error[2:]) & np.isfinite(inner)) + 1
    if not len(valley):
        return 0.0
    spread = float(np.nanvar(a, axis=0).mean())
    good = valley[error[valley] <= error[valley].min() + 1e-3 * spread]
    coarse = float(lags[good[np.argmin(np.abs(lags[good]))]]) * step

    def cost(late: float) -> float:
        return command_difference(reference, other, moving, late)

    found = minimize_scalar(
        cost, bounds=(coarse - 2 * step, coarse + 2 * step), method="bounded", options={"xatol": 1e-3 * step}
    )
    return float(found.x) if found.fun < cost(coarse) else coarse


def moving_commands(recording: Recording) -> Mask:
    """Which joints are commanded over more than 0.5° (0.0087 of the command's unit). Shape (n,)."""
    return np.asarray(command_range(recording) > MOVING)


def command_range(recording: Recording) -> Array:
    """The range that each joint is commanded over, in the command's unit; -inf where it never is. Shape (n,)."""
    command = recording.command
    known = np.isfinite(command)
    low = np.where(known, command, np.inf).min(axis=0, initial=np.inf)
    high = np.where(known, command, -np.inf).max(axis=0, initial=-np.inf)
    return np.asarray(high - low)


def command_difference(reference: Recording, other: Recording, joints: Mask, late: float) -> float:
    """The mean squared difference of two commands, the other one `late` seconds later; interpolated linearly."""
    clock, moved = reference.command_time, other.command_time - late
    both = (clock >= moved[0]) & (clock <= moved[-1])
    x = reference.command[both][:, joints]
    y = np.column_stack([np.interp(clock[both], moved, column) for column in other.command[:, joints].T])
    squares = (x - y) ** 2
    return float(np.nanmean(squares)) if np.isfinite(squares).any() else np.inf


def mean_squared_difference(a: Array, b: Array) -> tuple[Array, NDArray[np.intp]]:
    """The mean of (a[k] - b[k + lag])² over the samples that both have, for every lag, and the lags.

    By expanding the square into three correlations, each through the Fourier transform. NaN is no data; inf where
    fewer than half of the shorter one's samples meet. Shapes (ka, n) and (kb, n).
    """
    size = next_fast_len(len(a) + len(b) - 1, real=True)
    total, overlap = np.zeros(size), np.zeros(size)
    for x, y in zip(a.T, b.T, strict=True):
        middle = np.nanmean(x)  # the difference does not depend on it, rounding does
        known_x, known_y = np.isfinite(x).astype(float), np.isfinite(y).astype(float)
        x0, y0 = np.nan_to_num(x - middle), np.nan_to_num(y - middle)
        fx = np.conj(rfft(np.array([x0, x0 * x0, known_x]), size))
        fy = rfft(np.array([y0, y0 * y0, known_y]), size)
        total += irfft(fx[1] * fy[2] + fx[2] * fy[1] - 2 * fx[0] * fy[0], size)
        overlap += irfft(fx[2] * fy[2], size)
    lags = np.arange(-(len(a) - 1), len(b))
    enough = overlap[lags] >= 0.5 * min(np.isfinite(a).sum(), np.isfinite(b).sum())
    return np.where(enough, np.maximum(total[lags], 0.0) / np.maximum(overlap[lags], 1.0), np.inf), lags


def _sampled(recording: Recording, joints: Mask, step: float) -> Array:
    """The command of some joints at even steps of time from 0 on."""
    count = int(recording.trace.time[-1] / step) + 1
    return held_at(recording.command_time, recording.command[:, joints], np.asarray(step * np.arange(count)))
