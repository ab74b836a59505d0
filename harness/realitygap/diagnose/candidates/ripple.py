"""The periods of a ripple that a residual shows as a function of the joint's angle, told without simulating.

A ripple moves the joint, and the effort, by nearly the same sine of the angle: sine and cosine are fitted to the
residual beside a straight line at every period that the angles resolve (a Lomb-Scargle periodogram with a floating mean
and trend: Zechmeister and Kürster 2009). Every signal of every motion has an unknown noise of its own, so that a share
s that is explained of it counts −ln(1 − s): what is far off for another cause tells no more than the rest. All sums
that the fits take are transforms of what falls into narrow bins of the angle (Press and Rybicki 1989), at the grid's
periods alone (a chirp transform): over a joint that hardly moves the bins are so narrow that a turn has millions.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from scipy.ndimage import median_filter
from scipy.signal import czt
from scipy.special import gammainccinv

from realitygap.robot.drive import Array

STEP = 0.25
"""Spacing of the periods per 2π, for a joint that turns once at most: a quarter of what one turn tells apart."""
LOWEST, ORDINARY = 1.0, 61.0
"""Per 2π, the lowest per range of the motion as well (`joint.wave_unseen`). Up to the slots of a servo's motor times a
low gear's ratio the highest peaks are tried, whatever they are made of: slow residuals have many causes."""
FEWEST = 3
"""Periods of a grid at least: a peak is higher than those beside it."""
PEAKS = 3
"""Peaks that are tried, of either kind."""
CHANCE = 0.01
"""The odds that noise alone has a peak beyond `ORDINARY` that is tried."""
LOBES = 40
"""Widths of a peak over which the spectrum around it is looked at."""
NARROW = 8.0
"""Bins in the shortest period: its sums are 2.6 % too small then."""
ALL = 1.0 - 1e-9
"""A wave never explains more than this: readings are rounded."""
LEAST = 500
"""Bins in the range of the motion at least."""


def periods_of(angles: Sequence[Array], residuals: Sequence[Array], highest: float) -> list[float]:
    """The periods per 2π of a joint's angle (per 2π m of a slide) that its residual shows, the likeliest first.

    Args:
        angles: of every motion [rad or m], NaN where unknown. Shapes (t,).
        residuals: of every motion, by signal, NaN where unknown. Shapes (t, k).
        highest: that is looked for.
    """
    known = [np.isfinite(r).all(axis=1) & np.isfinite(a) for a, r in zip(angles, residuals, strict=True)]
    runs = [(a[k], r[k]) for a, r, k in zip(angles, residuals, known, strict=True) if k.sum() > 3 and np.ptp(a[k]) > 0]
    if not runs:
        return []
    widest = max(float(np.ptp(a)) for a, _ in runs)
    step = min(STEP, 2.0 * math.pi / widest * STEP)
    tops = [min(resolved(a), highest) for a, _ in runs]
    lowest = LOWEST * max(1.0, 2.0 * math.pi / widest)
    first, end = math.ceil(lowest / step), math.ceil(max(*tops, ORDINARY) / step)
    if end - first < FEWEST:
        return []
    grid: Array = step * np.arange(first, end, dtype=float)
    powers = [power(a, r, grid) for a, r in runs]
    slow = np.where(grid < ORDINARY, -sum(np.log1p(-p).sum(axis=1) for p in powers), 0.0)
    fast, many = np.zeros(len(grid)), np.zeros(len(grid))
    lobe = max(1, round(2.0 * math.pi / widest / step))
    for p, top in zip(powers, tops, strict=True):
        seen = int(np.searchsorted(grid, top))
        inside = np.arange(len(grid)) < seen * (grid >= ORDINARY)
        if inside.any():
            for column in p[:seen].T:
                around = median_filter(column, size=LOBES * lobe, mode="reflect") / math.log(2.0)
                fast[:seen] += column / np.maximum(around, 1e-300)
            many[inside] += p.shape[1]
    by_chance = gammainccinv(np.maximum(many, 1.0), CHANCE * lobe / len(grid))
    return [*_peaks(grid, slow, 1), *_peaks(grid, np.where((grid >= ORDINARY) & (fast > by_chance), fast, 0.0), lobe)]


def resolved(angle: Array) -> float:
    """The periods per 2π of which half of the samples that move see two or more."""
    moved = np.abs(np.diff(angle))
    return math.pi / float(np.median(moved[moved > 0.0]))


def power(angle: Array, residual: Array, grid: Array) -> Array:
    """The share that a sine at each period of an even grid explains of a residual (t, k) beside a straight line.

    Shape (p, k), less than one.
    """
    step = float(grid[1] - grid[0])
    wide = 1.0 / max(NARROW * float(grid[-1]) / (2.0 * math.pi), LEAST / float(np.ptp(angle)))  # of a bin [rad]
    bins = np.floor((angle - angle.min()) / wide).astype(int)
    plain, _ = np.linalg.qr(np.column_stack([np.ones(len(bins)), bins - bins.mean()]))
    rest = residual - plain @ (plain.T @ residual)
    columns = np.column_stack([np.ones(len(angle)), plain, rest])
    sums = np.array([np.bincount(bins, column) for column in columns.T])
    at, twice = np.rint(grid / step).astype(int), np.rint(2.0 * grid / step).astype(int)
    waves = czt(sums, int(twice[-1]) + 1, np.exp(1j * step * wide))  # sums of exp(i·k·step·angle), from the first bin
    once, double = waves[:, at], waves[0, twice]
    number = float(len(angle))
    cosine = 0.5 * (number + double.real) - (once[1:3].real ** 2).sum(axis=0)
    sine = 0.5 * (number - double.real) - (once[1:3].imag ** 2).sum(axis=0)
    both = 0.5 * double.imag - (once[1:3].real * once[1:3].imag).sum(axis=0)
    c, s = once[3:].real.T, once[3:].imag.T
    determinant = cosine * sine - both**2
    told = determinant > 1e-10 * number * (cosine + sine)  # a wave and a line that differ
    with np.errstate(divide="ignore", invalid="ignore"):
        found = (sine[:, None] * c**2 - 2.0 * both[:, None] * c * s + cosine[:, None] * s**2) / determinant[:, None]
    share = found / np.maximum((rest**2).sum(axis=0), 1e-300)
    return np.where(told[:, None], np.clip(share, 0.0, ALL), 0.0)


def _peaks(grid: Array, score: Array, apart: int) -> list[float]:
    """Where a score is highest of all around, the highest first, at least so many steps apart."""
    inner = score[1:-1]
    peaks = np.flatnonzero((inner > 0.0) & (inner >= score[:-2]) & (inner >= score[2:])) + 1
    out: list[int] = []
    for k in peaks[np.argsort(-score[peaks], kind="stable")]:
        if len(out) < PEAKS and all(abs(int(k) - other) >= apart for other in out):
            out.append(int(k))
    return [float(grid[k]) for k in out]
