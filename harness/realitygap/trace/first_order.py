"""First-order recursion, as of a low-pass, without loading SciPy's signal processing, which loads all of statistics."""

import numpy as np
from scipy.linalg import solve_banded

from realitygap.trace.trace import Array


def first_order(given: Array, keep: float | Array, before: float = 0.0) -> Array:
    """What is given at each sample and a share of the value at the one before: y[k] = keep[k]·y[k-1] + given[k].

    Args:
        given: at each sample. Shape (t,).
        keep: of the value before, one for all or Shape (t,).
        before: the value before the first sample.

    Returns:
        y. Shape (t,).
    """
    kept = np.broadcast_to(keep, len(given))
    first = given[:1] + kept[:1] * before
    steps_back = np.stack([np.ones(len(given)), np.append(-kept[1:], 0.0)])  # each value less what is kept
    return np.asarray(solve_banded((1, 0), steps_back, np.concatenate([first, given[1:]])))
