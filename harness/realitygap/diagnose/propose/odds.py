"""Expected odds: how far a motion will part explanations, after each has been refitted to it and to what was there.

An explanation is a normal belief about its values and about how far its laws are off, as the present recordings leave
it, and says what a motion will show by straight lines. What it predicts is thus normal, too, and the expected logarithm
of the odds that new recordings add for the true one is the divergence of the two predictions (Kullback & Leibler 1951;
as a criterion for design Box & Hill 1967). Its largest part is half the squared distance that is left when the other
one is refitted to the new motion together with the old ones, weighted by what is known of its values (Hunter & Reiner
1965; of several rivals the smallest counts, Buzzi-Ferraris & Forzatti 1983); the rest is what is uncertain in the true
one.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from realitygap.robot.drive import Array


@dataclass(frozen=True)
class Belief:
    """What an explanation expects of new motions.

    Predictions are combinations of common columns, whose inner products are all that is needed of a motion.

    Attributes:
        mean: the combination that is expected. Shape (c,).
        ways: the combinations that a unit of each value adds. Shape (c, v).
        precision: of the values, on the present recordings. Shape (v, v).
        start: how far the present recordings have the values from where `ways` begin. Shape (v,).
    """

    mean: Array
    ways: Array
    precision: Array
    start: Array = field(default_factory=lambda: np.zeros(0))

    @property
    def covariance(self) -> Array:
        """Of the values. Shape (v, v)."""
        return np.asarray(np.linalg.inv(self.precision)) if len(self.precision) else self.precision

    def learned(self, gram: Array) -> Array:
        """The precision of the values with a motion, or several, in addition. Shape (v, v)."""
        return np.asarray(self.precision + self.ways.T @ gram @ self.ways)


def moved(gram: Array, apart: Array, other: Belief) -> tuple[Array, float]:
    """How an explanation's values move in a refit to motions that differ from what it predicts, and what stays: the
    squared distance, with what the move costs on the present recordings.

    Args:
        gram: of the motions. Shape (c, c).
        apart: what they show less what the explanation predicts, as a combination of the columns. Shape (c,).
        other: the explanation.
    """
    distance = float(apart @ gram @ apart)
    if not len(other.precision):
        return np.zeros(0), distance
    seen = other.ways.T @ gram @ apart
    values = cho_solve(cho_factor(other.learned(gram), lower=True), seen)
    return np.asarray(values), distance - float(seen @ values)


def expected(gram: Array, true: Belief, other: Belief, distance: float | None = None) -> float:
    """The logarithm of the odds that motions are expected to add for the true explanation over another one.

    Args:
        gram: inner products of the columns over the motions, in units of noise, disturbances and law discrepancy.
            Shape (c, c).
        true: the explanation that holds.
        other: the one that is refitted.
        distance: what its refit leaves (`moved`), where that was simulated; None by straight lines.
    """
    apart = true.mean - other.mean
    here, there = true.ways.T @ gram @ true.ways, other.ways.T @ gram @ other.ways
    both = other.ways.T @ gram @ true.ways
    spread = float(np.trace(true.covariance @ here))
    if len(there):
        factor = cho_factor(other.precision + there, lower=True)
        spread -= float(np.trace(cho_solve(factor, there + both @ true.covariance @ both.T)))
    if distance is None:
        distance = moved(gram, apart, other)[1]
    return 0.5 * (distance + spread + _gained(other, there) - _gained(true, here))


def _gained(belief: Belief, information: Array) -> float:
    """The logarithm of how much more is known of the values, in volume squared."""
    if not len(information):
        return 0.0
    return float(np.linalg.slogdet(belief.precision + information)[1] - np.linalg.slogdet(belief.precision)[1])


def deviation(gram: Array, belief: Belief) -> Array:
    """Standard deviations of the values after motions. Shape (v,)."""
    return np.asarray(np.sqrt(np.diag(np.linalg.inv(belief.learned(gram)))))
