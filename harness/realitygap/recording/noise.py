"""How large the noise of a measured signal is, from the signal itself."""

import numpy as np
from numpy.typing import NDArray

from realitygap.recording.quantum import quantum
from realitygap.trace.trace import Array

FEWEST = 20
"""Samples that tell how large their own noise is."""
MOVED = 5.0
"""The spread of travel over that of its own noise: of 789,000 joints at rest, of 20 to 1000 samples of white noise, 7
passed 5, and none of 30 samples or more passed 4.4. Where real robots move, 12.7 was the least of 723."""


def own_noise(value: Array) -> Array:
    """The noise of one recording of a smooth signal. Shape (t, n) -> (n,).

    The larger of the rounding of its quantum (q/√12) and the spread of its third differences, in which a motion that
    is smooth against the sampling is gone (σ = spread/√20). The spread is taken from the median, because jerks of the
    real motion stand out in a few samples only. 0 for a signal that never changes or never was measured.
    """
    rounding = quantum(value) / np.sqrt(12)
    if len(value) < 8:
        return np.asarray(rounding)
    third = np.diff(value, n=3, axis=0)
    known = np.isfinite(third).any(axis=0)
    spread = np.zeros(value.shape[1])
    if known.any():
        away = np.abs(third[:, known] - np.nanmedian(third[:, known], axis=0))
        spread[known] = 1.4826 * np.nanmedian(away, axis=0) / np.sqrt(20)
    return np.asarray(np.maximum(rounding, spread))


def beyond_noise(travel: Array, value: Array) -> NDArray[np.bool_]:
    """Whether differences (k, n) of a signal (t, n) between two times spread by more than its noise makes them. Shape
    (n,).
    """
    spread = travel.std(axis=0) > MOVED * np.sqrt(2.0) * own_noise(value)
    return np.asarray(spread & (len(value) >= FEWEST))
