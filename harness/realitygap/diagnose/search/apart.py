"""Where in the recordings two models differ: whether stretches of them tell the two apart, and what of it is where.

The test of Vuong (1989), with stretches that are nearly independent in the place of samples.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtrit

from realitygap.diagnose.likelihood.whitening import Channel
from realitygap.diagnose.search.evidence import Scored, stretches
from realitygap.robot.drive import Array

SURE = 0.95
"""How sure the recordings have to be of a difference, one-sided."""
ERRORS = 1.64
"""Standard errors of a difference that recordings do not tell apart, so sure."""


def compare(channels: Sequence[Channel], best: Scored, other: Scored) -> tuple[float, float]:
    """How much evidence another model has less than the best one, and the standard error of that."""
    number = stretches(channels)
    a, b = (_densities(number, s) for s in (best, other))
    return best.evidence - other.evidence, scatter(a - b)


def told_apart(best: Scored, other: Scored) -> float:
    """The evidence that recordings are expected to give for the one of two models that is true over the other one: half
    of the squared length of what parts their traces, whitened (the divergence of Kullback & Leibler 1951).
    """
    return 0.5 * float(np.sum(best.metric(best.fit.residual - other.fit.residual) ** 2))


def scatter(parts: Array) -> float:
    """The standard error of the sum of nearly independent parts, (n,), of which `ERRORS` make its limit at 95 %.

    Of few parts it is larger, as these tell their own scatter badly (Student's t): with two, a sum of no mean exceeds
    1.64 of the plain ones in 23 of 100. One part tells no scatter: evidence alone has to say it.
    """
    if len(parts) < 2:
        return 0.0
    few = float(stdtrit(len(parts) - 1, SURE)) / ERRORS
    return few * float(np.sqrt(len(parts)) * np.std(parts, ddof=1))


def _densities(number: NDArray[np.int64], scored: Scored) -> Array:
    """The logarithm of the density of every part of the recordings, beside a constant.

    `number` is that of the part of every stacked sample, (m,), as of its stretch, all channels of it together.
    """
    whitening, weight = scored.metric.whitening, scored.metric.weight
    rows = whitening.rows
    white, trust = scored.metric(scored.fit.residual)[: len(rows)], weight[rows]
    good = trust > 0.0
    spread = np.zeros(len(rows))
    spread[good] = whitening.share[good] * np.log(whitening.variance[good] / trust[good])
    return np.asarray(-0.5 * np.bincount(number[rows], white**2 + spread, minlength=int(number.max()) + 1))


def reached(channels: Sequence[Channel], explained: tuple[Scored, Scored], change: Array) -> float:
    """The share of what one model explains beyond another that a change of the residual could mend at most, whatever
    laws are off by: it acts at some joints, and what laws at others leave is not in its way.

    With unit vectors of what is explained and of the change, both whitened, the square of their product is at most that
    of the product of their lengths in each joint's channels, added up (Cauchy & Schwarz).

    Args:
        channels: of the stacked residual, each of a joint.
        explained: the model that explains more, and the other.
        change: of the residual; NaN where nothing was measured. Shape (m,).
    """
    number = np.repeat([c.column for c in channels], [len(c.time) for c in channels])
    more, less = (_densities(number, s) for s in explained)
    there = np.maximum(more - less, 0.0)
    whitening, weight = explained[0].metric.whitening, explained[0].metric.weight
    white = whitening(np.nan_to_num(change)[:, None], weight)[0][:, 0]
    acts = np.bincount(number[whitening.rows], white**2, minlength=len(there))
    both = float(there.sum() * acts.sum())
    return float(np.sqrt(there * acts).sum()) ** 2 / both if both > 0.0 else 1.0
