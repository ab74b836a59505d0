"""Whether repetitions of a motion reproduce it, and how long two of them that are alike stay alike.

Where they do not, their mean is no motion: a pendulum on a pendulum, or an axis that hunts in its play, forgets how it
began, and what it does then tells of no law. How fast it forgets, the repetitions tell without any model: moments at
which two of them are alike by chance or from the start, and what becomes of their difference (analogues; Lorenz 1969,
J. Atmos. Sci. 26).
"""

from __future__ import annotations

from itertools import combinations

import numpy as np

from realitygap.robot.drive import Array

STRETCH = 0.5
"""What a motion does is looked at over stretches of this length [s]: a servo's position loop has answered by then."""
LOUD = 5.0
"""A stretch is not reproduced where repetitions vary in it by more than this, in standard deviations of the sensor,
and by more than `SHARE` of what they do together, in variance ..."""
SHARE = 0.25
UNLIKE = 0.25
"""... and a motion is not, where this share of its stretches is not."""
NEAR = 3.0
"""Two repetitions are alike where they differ by no more than this, in standard deviations of a difference ..."""
WHILE = 0.05
"""... for this long [s], so that they go the same way."""
APART = 5.0
"""They are alike no more where they differ by more than this in root mean square."""
FEWEST = 10
"""Moments that must be alike for the rest to mean anything."""


def reproduced(time: Array, values: Array, noise: Array) -> bool:
    """Whether repetitions reproduce a motion over all of it.

    Args:
        time: their common clock [s]. Shape (t,).
        values: their readings. Shape (r, t, n).
        noise: of the sensors. Shape (n,).
    """
    count = len(values)
    mean = values.mean(axis=0)
    unlike = []
    for begin in np.arange(time[0], time[-1] - 0.5 * STRETCH, STRETCH):
        inside = (time >= begin) & (time < begin + STRETCH)
        if inside.sum() < 3:
            continue
        together = np.var(mean[inside], axis=0)
        own = np.mean(np.var(values[:, inside] - mean[inside], axis=1), axis=0) * count / (count - 1)
        unlike.append((own > (LOUD * noise) ** 2) & (own > SHARE * together))
    return not unlike or bool(np.mean(unlike, axis=0).max(initial=0.0) <= UNLIKE)


def alike_for(time: Array, values: Array, noise: Array) -> float | None:
    """How long repetitions that are alike stay alike [s]; None where hardly any two of them ever are. As above."""
    period = (time[-1] - time[0]) / (len(time) - 1)
    size = max(round(WHILE / period), 3)
    total, number = np.zeros((len(time), len(noise))), np.zeros(len(time))
    for a, b in combinations(values, 2):
        difference = ((a - b) / (np.sqrt(2.0) * noise)) ** 2
        near = (difference <= NEAR**2).all(axis=1)
        runs = np.convolve(near, np.ones(size), mode="valid") == size
        for k in np.flatnonzero(runs):
            rest = difference[k:]
            total[: len(rest)] += rest
            number[: len(rest)] += 1
    if number[0] < FEWEST:
        return None
    known = number >= FEWEST
    apart = np.sqrt((total[known] / number[known, None]).max(axis=1)) > APART
    far = int(np.argmax(apart)) if apart.any() else len(apart)
    return float(far * period)
