"""The resolution of a sensor, as its readings show it."""

import numpy as np

from realitygap.trace.trace import Array


def quantum(value: Array) -> Array:
    """The smallest step that a sensor was seen to make, per column. Shape (t, n), gives (n,); 0 for a constant.

    Steps below 1e-5 of the largest value are rounding of a file, not the sensor.
    """
    steps = np.abs(np.diff(value, axis=0))
    rounding = 1e-5 * np.nanmax(np.abs(value), axis=0, initial=0.0)
    smallest = np.where(steps > rounding, steps, np.inf).min(axis=0, initial=np.inf)
    return np.asarray(np.where(np.isfinite(smallest), smallest, 0.0))
