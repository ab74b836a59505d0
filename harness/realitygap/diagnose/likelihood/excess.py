"""Excess variance: what lasts in a residual beyond the floors, which no law explains."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np
from realitygap_engines.law.compiled import compiled

from realitygap.diagnose.likelihood.whitening import Channel
from realitygap.robot.drive import Array

SHARED = 4.0
"""Facts of a motion that are worth as much as what the other motions say about what no law explains in it."""
STEPS, EXACT = 100, 1e-3
"""Newton's steps at most, and how far from one a mean may stay."""


def excess_deviation(channels: Sequence[Channel], effective_fraction: Array, residual: Array) -> Array:
    """The excess standard deviation of a residual, by channel of each motion (Paule & Mandel 1982). Shape (channels,).

    The standard deviation of what lasts beyond the floors and no law explains: that with which the mean square of what
    is left, each sample in its own deviation, is one (the method of moments, as for the variance between studies).
    Where the floor is high, little is told of it. What laws leave is larger in a fast motion than in a slow one; so
    each motion has its own, of which all motions of the channel say as much as `SHARED` effective samples of it would,
    each as much as the other, however long.

    Args:
        channels: of the stacked residual.
        effective_fraction: how many effective samples a sample of each channel is. Shape (channels,).
        residual: NaN where nothing was measured. Shape (m,).
    """
    keys = list(dict.fromkeys(c.key for c in channels))
    which = np.array([keys.index(c.key) for c in channels])
    ends = np.cumsum([0, *(len(c.time) for c in channels)])
    return np.asarray(
        _excess_deviation(residual, np.concatenate([c.floor for c in channels]), ends, which, effective_fraction)
    )


@partial(compiled, nogil=True)
def _excess_deviation(residual, floor, ends, which, effective_fraction):  # type: ignore[no-untyped-def]
    """Of the variance `floor` (m,), where channel k has samples `ends[k]` to `ends[k + 1]` and those of one signal and
    joint have the same number in `which` (k,).

    The variance that has to be added for the mean of scaled squares to be one: Newton's method, from below, on the
    inverse of that mean, which is concave and nearly linear.
    """
    count = len(which)
    known, motions = np.zeros(count), np.zeros(which.max() + 1)
    for k in range(count):
        known[k] = np.sum(np.isfinite(residual[ends[k] : ends[k + 1]]))
        motions[which[k]] += known[k] > 0.0
    out = np.zeros(count)
    for k in range(count):
        if known[k] == 0.0:
            continue
        total, added = SHARED + effective_fraction[k] * known[k], 0.0
        for _ in range(STEPS):
            mean, falls = 0.0, 0.0
            for j in range(count):
                if which[j] != which[k] or known[j] == 0.0:
                    continue
                one, slope = 0.0, 0.0
                for i in range(ends[j], ends[j + 1]):
                    if np.isfinite(residual[i]):
                        variance = floor[i] + added
                        scaled = residual[i] * residual[i] / variance
                        one += scaled
                        slope += scaled / variance
                share = (SHARED / (known[j] * motions[which[k]]) + (effective_fraction[k] if j == k else 0.0)) / total
                mean += share * one
                falls += share * slope
            if mean <= 1.0 + EXACT:
                break
            added += (mean - 1.0) * mean / falls
        out[k] = np.sqrt(added)
    return out
