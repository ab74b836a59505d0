"""How large the noise of a measured signal is: from repetitions, or from the signal itself."""

from collections.abc import Sequence

import numpy as np

from realitygap.recording.quantum import quantum
from realitygap.robot.drive import Array


def repetition_noise(values: Sequence[Array]) -> Array:
    """The standard deviation between repetitions on one clock, pooled over time. Shapes (t, n) -> (n,).

    Of what is known in two of them at least; 0 where nothing is.
    """
    stacked = np.array(values)
    known = np.isfinite(stacked).sum(axis=0) > 1
    variance = np.zeros(known.shape)
    variance[known] = np.nanvar(stacked[:, known], axis=0, ddof=1)
    return np.asarray(np.sqrt(variance.sum(axis=0) / np.maximum(known.sum(axis=0), 1)))


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


def shared_noise(own: Sequence[Array]) -> list[Array]:
    """The noise of like channels in several recordings, where some never change and so tell nothing of theirs.

    Such a channel is as noisy as in the other recordings, or else as the other channels. Shapes (n,); 0 where nothing
    ever changes.
    """
    table = np.array(own)
    told = table > 0
    if not told.any():
        return list(own)
    count = told.sum(axis=0)
    elsewhere = np.where(count > 0, table.sum(axis=0) / np.maximum(count, 1), np.median(table[told]))
    return list(np.where(told, table, elsewhere))


def local_maximum(value: Array, reach: int) -> Array:
    """The largest of the neighbours up to `reach` samples away. Shape (t, n) -> (t, n)."""
    out = value.copy()
    for k in range(1, reach + 1):
        out[k:] = np.maximum(out[k:], value[:-k])
        out[:-k] = np.maximum(out[:-k], value[k:])
    return out
