"""How large the noise of a measured signal is by its repetitions, and what like channels share of it."""

from collections.abc import Sequence

import numpy as np

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
