"""Fits of splines to a missing effort, judged on parts of the recordings that were not fitted."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve

from realitygap.missing.splines import Spline
from realitygap.trace.trace import Array

PENALTIES = tuple(10.0**k for k in range(-3, 6))
"""Of the roughness, for samples whose weights have the mean 1."""
RIDGE = 1e-6
"""Of all values, so that those without samples are told."""


@dataclass(frozen=True)
class EffortSamples:
    """Samples of a missing effort on one joint.

    Attributes:
        effort: less its mean [N·m or N]. Shape (t,).
        weight: with the mean 1. Shape (t,).
        columns: the variables at the samples. Each shape (t,).
        fold: which part each sample belongs to. Shape (t,).
    """

    effort: Array
    weight: Array
    columns: dict[str, Array]
    fold: NDArray[np.int64]

    @property
    def folds(self) -> int:
        """How many parts there are."""
        return int(self.fold.max()) + 1


@dataclass(frozen=True)
class Fitted:
    """A sum of splines, fitted.

    Attributes:
        splines: the terms.
        values: of each at its knots. Shapes (size,).
        penalties: of each.
        left: the mean squared error on every part, fitted to the others. Shape (folds,).
    """

    splines: tuple[Spline, ...]
    values: tuple[Array, ...]
    penalties: tuple[float, ...]
    left: Array

    @property
    def mean_left(self) -> float:
        """The mean of what is left over the parts."""
        return float(self.left.mean())


def fit(
    samples: EffortSamples, splines: Sequence[Spline], penalties: Sequence[Sequence[float]] | None = None
) -> Fitted:
    """A sum of splines with the penalties that leave least on the parts that were not fitted.

    Args:
        samples: what is fitted.
        splines: the terms.
        penalties: those to try, one of each term; None: the same of `PENALTIES` for all.
    """
    design = np.hstack([s.design(samples.columns) for s in splines])
    sizes = [s.size for s in splines]
    weighted = design * samples.weight[:, None]
    grams, sides, squares = [], [], []
    for part in range(samples.folds):
        rows = samples.fold == part
        grams.append(weighted[rows].T @ design[rows])
        sides.append(weighted[rows].T @ samples.effort[rows])
        squares.append(float(samples.weight[rows] @ samples.effort[rows] ** 2))
    counts = np.array([samples.weight[samples.fold == part].sum() for part in range(samples.folds)])
    gram, side = np.sum(grams, axis=0), np.sum(sides, axis=0)
    best: tuple[Array, Sequence[float], Array] | None = None
    for tried in penalties or [[p] * len(splines) for p in PENALTIES]:
        rough = _rough(splines, sizes, tried)
        left = np.empty(samples.folds)
        for part in range(samples.folds):
            values = _solved(gram - grams[part] + rough, side - sides[part])
            left[part] = (squares[part] - 2 * values @ sides[part] + values @ grams[part] @ values) / counts[part]
        if best is None or left.mean() < best[0].mean():
            best = left, tried, rough
    assert best is not None
    values = _solved(gram + best[2], side)
    return Fitted(tuple(splines), tuple(np.split(values, np.cumsum(sizes)[:-1])), tuple(best[1]), best[0])


def nothing(samples: EffortSamples) -> Array:
    """What the mean of the other parts leaves on every part. Shape (folds,)."""
    left = np.empty(samples.folds)
    for part in range(samples.folds):
        own = samples.fold == part
        mean = np.average(samples.effort[~own], weights=samples.weight[~own])
        left[part] = np.average((samples.effort[own] - mean) ** 2, weights=samples.weight[own])
    return left


def _rough(splines: Sequence[Spline], sizes: Sequence[int], penalties: Sequence[float]) -> Array:
    out, at = np.zeros((sum(sizes), sum(sizes))), 0
    for one, size, penalty in zip(splines, sizes, penalties, strict=True):
        out[at : at + size, at : at + size] = penalty * one.penalty() + RIDGE * np.eye(size)
        at += size
    return out


def _solved(matrix: Array, side: Array) -> Array:
    return np.asarray(cho_solve(cho_factor(matrix), side))
