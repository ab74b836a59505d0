"""Whether recordings tell two models apart: the difference in evidence beside what stretches of them scatter by.

The test of Vuong (1989), with stretches that are nearly independent in the place of samples.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from realitygap.diagnose.likelihood.whitening import Channel
from realitygap.diagnose.search.evidence import Scored, stretches
from realitygap.robot.drive import Array

ERRORS = 1.64
"""Standard errors of a difference that recordings do not tell apart: 95 %, one-sided."""


def compare(channels: Sequence[Channel], best: Scored, other: Scored) -> tuple[float, float]:
    """How much evidence another model has less than the best one, and the standard error of that."""
    number = stretches(channels)
    a, b = (_stretches(number, s) for s in (best, other))
    apart = a - b
    error = float(np.sqrt(len(apart)) * np.std(apart)) if len(apart) > 1 else 0.0
    return best.evidence - other.evidence, error


def _stretches(number: NDArray[np.int64], scored: Scored) -> Array:
    """The logarithm of the density of every stretch of every motion, all channels of it together, beside a constant.

    `number` is that of the stretch of every stacked sample, (m,).
    """
    whitening, weight = scored.metric.whitening, scored.metric.weight
    rows = whitening.rows
    white, trust = scored.metric(scored.fit.residual)[: len(rows)], weight[rows]
    good = trust > 0.0
    spread = np.zeros(len(rows))
    spread[good] = whitening.share[good] * np.log(whitening.variance[good] / trust[good])
    return np.asarray(-0.5 * np.bincount(number[rows], white**2 + spread, minlength=int(number.max()) + 1))
