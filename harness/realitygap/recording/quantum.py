"""The resolution of a sensor, as its readings show it."""

import numpy as np

from realitygap.trace.trace import Array

GARBLED = 1e-3
"""The share of readings that may be garbled, beside a single one, and are no size of what is measured."""


def quantum(value: Array) -> Array:
    """The smallest step that a sensor was seen to make, per column. Shape (t, n), gives (n,); 0 for a constant.

    Steps below 1e-5 of the largest value that is not `GARBLED` are rounding of a file, not the sensor.
    """
    return np.array([_smallest(column) for column in value.T])  # a column at a time: recordings are long


def _smallest(column: Array) -> float:
    steps, sizes = np.abs(np.diff(column)), np.abs(column[~np.isnan(column)])
    if not sizes.size:
        return 0.0
    last = max(sizes.size - 2 - int(GARBLED * sizes.size), 0)
    seen = steps[steps > 1e-5 * np.partition(sizes, last)[last]]
    return float(seen.min(initial=np.inf)) if seen.size else 0.0
