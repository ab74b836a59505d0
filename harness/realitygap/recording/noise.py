"""How large the noise of a measured signal is, from the signal itself."""

import numpy as np

from realitygap.recording.quantum import quantum
from realitygap.trace.trace import Array


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
