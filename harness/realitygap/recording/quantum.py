"""The resolution of a sensor, as its readings show it."""

import numpy as np

from realitygap.trace.trace import Array


def quantum(value: Array) -> Array:
    """The smallest step that a sensor was seen to make, per column. Shape (t, n), gives (n,); 0 for a constant.

    Steps below 1e-5 of the largest value are rounding of a file, not the sensor.
    """
    return np.array([_smallest(column) for column in value.T])  # a column at a time: recordings are long


def _smallest(column: Array) -> float:
    steps = np.abs(np.diff(column))
    seen = steps[steps > 1e-5 * np.nanmax(np.abs(column), initial=0.0)]
    return float(seen.min(initial=np.inf)) if seen.size else 0.0
