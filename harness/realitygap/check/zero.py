"""The error at which a servo gives nothing: that of another zero, however weak the servo is and whatever it carries."""

import numpy as np
from scipy.ndimage import uniform_filter1d

from realitygap.check.observed import Mask, Observed
from realitygap.check.servo import limit, stiffness
from realitygap.trace.trace import Array

SMOOTHED = 0.05
"""s: the mean over which errors and efforts are compared."""
SLOW = 0.1
"""The share of its usual fastest speed below which a joint rests."""
FEWEST = 50
"""Samples that tell how an error goes with an effort, either way."""
FREE = 0.8
"""The share of the largest effort beyond which a servo may be at its limit, where errors say nothing."""
WITHIN = 10.0
"""A servo is stiffer or weaker than it says by less than this, or the effort is none of its error."""


def unloaded_error(o: Observed, j: int) -> float:
    """How far a position is from its command where the measured effort is none [rad or m], whichever way it moves; 0
    where that is not told.

    position - command = zero - effort/stiffness + late·speed, by least squares, apart for each way of motion: friction,
    a load, a weak gain and a late command are in the effort or change their sign with the motion. The smaller of both
    ways is told, where they agree.
    """
    if o.effort is None or o.plant.drive["ki"][j] > 0:
        return 0.0
    width = max(1, round(SMOOTHED / o.step))
    away, effort = o.position[:, j] - o.command[:, j], o.effort[:, j]
    known = np.isfinite(away) & np.isfinite(effort)
    away, effort, speed = (
        uniform_filter1d(np.where(known, x, 0.0), width) for x in (away, effort, np.gradient(o.position[:, j], o.step))
    )
    known = np.convolve(~known, np.ones(2 * width + 1), "same") < 0.5
    if known.sum() < 2 * FEWEST:
        return 0.0
    free = known & (np.abs(effort) < FREE * min(np.abs(effort[known]).max(), limit(o)[j]))
    slow = SLOW * float(np.quantile(np.abs(speed[known]), 0.9))
    ways = [_zero(away, effort, speed, free & side) for side in (speed > slow, speed < -slow)]
    zeros, gives = zip(*ways, strict=True)
    stiff = float(stiffness(o)[j])
    fits = all(1.0 / WITHIN < -give * stiff < WITHIN for give in gives)
    return float(min(zeros, key=abs)) if fits and zeros[0] * zeros[1] > 0 else 0.0


def _zero(away: Array, effort: Array, speed: Array, chosen: Mask) -> tuple[float, float]:
    """How far a position is from its command without effort and at rest, and how much further per effort."""
    if chosen.sum() < FEWEST:
        return 0.0, 0.0
    x = np.column_stack([np.ones(int(chosen.sum())), effort[chosen], speed[chosen]])
    weights = np.linalg.lstsq(x, away[chosen], rcond=None)[0]
    return float(weights[0]), float(weights[1])
