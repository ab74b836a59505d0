"""First-order recursion, as of a low-pass."""

import numpy as np
from numba import njit

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
    out = np.array(given, dtype=np.float64)
    _recursion(out, np.full(len(out), keep, dtype=np.float64), before)
    return out


@njit("void(f8[::1], f8[::1], f8)", cache=True)  # compiled when it is loaded, for no deadline to hang on the first call
def _recursion(given, keep, value):  # type: ignore[no-untyped-def]
    """In place."""
    for k in range(given.size):
        value = keep[k] * value + given[k]
        given[k] = value
