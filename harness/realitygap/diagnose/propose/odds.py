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
from functools import cached_property

import numpy as np

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

    @cached_property
    def covariance(self) -> Array:
        """Of the values. Shape (v, v)."""
        return np.asarray(np.linalg.inv(self.precision)) if len(self.precision) else self.precision

    @cached_property
    def known(self) -> float:
        """The logarithm of the determinant of the precision."""
        return float(np.linalg.slogdet(self.precision)[1])

    def learned(self, gram: Array) -> Array:
        """The precision of the values with a motion, or several, in addition. Shape (..., v, v)."""
        return np.asarray(self.precision + self.ways.T @ gram @ self.ways)


def expected(gram: Array, true: Belief, other: Belief) -> Array:
    """The logarithm of the odds that motions are expected to add for the true explanation over another one.

    Args:
        gram: inner products of the columns over the motions, in units of noise, disturbances and law discrepancy; any
            number of them. Shape (..., c, c) -> (...).
        true: the explanation that holds.
        other: the one that is refitted.
    """
    apart = true.mean - other.mean
    shown, here, there = gram @ apart, true.learned(gram), other.learned(gram)
    both = other.ways.T @ gram @ true.ways
    seen = shown @ other.ways
    new = there - other.precision + both @ true.covariance @ np.swapaxes(both, -1, -2)
    solved = np.linalg.solve(there, np.concatenate([new, seen[..., None]], axis=-1))
    distance = shown @ apart - np.sum(seen * solved[..., -1], axis=-1)
    spread = np.sum(true.covariance * (here - true.precision), axis=(-1, -2))
    spread -= np.trace(solved[..., :-1], axis1=-2, axis2=-1)
    gained = (np.linalg.slogdet(there)[1] - other.known) - (np.linalg.slogdet(here)[1] - true.known)
    return np.asarray(0.5 * (distance + spread + gained))


def deviation(gram: Array, belief: Belief) -> Array:
    """Standard deviations of the values after motions. Shape (..., c, c) -> (..., v)."""
    return np.asarray(np.sqrt(np.diagonal(np.linalg.inv(belief.learned(gram)), axis1=-2, axis2=-1)))
