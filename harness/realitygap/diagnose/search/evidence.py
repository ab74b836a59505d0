"""The evidence of a model: one number for every move of the search.

The marginal likelihood of the residual, with the fitted values integrated out (Laplace), what no law explains estimated
for this model, and imperfections of all laws marginalised at the scale that the recordings support best. "Something
else" is thus a model too, the one that has no change and leaves everything to what no law explains: a name has to beat
it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from realitygap.diagnose.fit.fit import SLAB, Fit
from realitygap.diagnose.likelihood.metric import Metric, metric, rest_of
from realitygap.diagnose.likelihood.whitening import Channel
from realitygap.robot.drive import Array

IMPERFECT = {0.1: -8.0, 0.2: 0.0, 0.4: 0.0}
"""How imperfect laws are, as a share of the visible first size of every effect on the list, with the logarithm of the
odds beforehand. 0.2 is 3 % of a torque constant, 0.4 % of the stall torque in friction, 4 % of a mass: real laws are
known to 5 to 10 % of what they do. Better laws have to be earned by the recordings (3000 : 1)."""
PASSES = 2
"""How often what no law explains is estimated anew from what the imperfections leave."""


@dataclass(frozen=True)
class Imperfections:
    """What all models of a round are compared with.

    Attributes:
        facts: how many facts a sample of each channel is, where the search stands. Shape (channels,).
        responses: of the laws that may be imperfect, at the model that the search stands at. Shape (m, q).
    """

    facts: Array
    responses: Array


@dataclass(frozen=True)
class Scored:
    """A fit with its evidence, the metric in which it was found, and how imperfect laws are in it."""

    fit: Fit
    evidence: float
    metric: Metric
    imperfect: float

    @cached_property
    def covariance(self) -> Array:
        """Of the fitted values, in sizes². Shape (p, p)."""
        if not len(self.fit.names):
            return np.zeros((0, 0))
        slope, whole = self.metric(self.fit.slope), self.metric(self.fit.residual)
        model = np.asarray(np.linalg.inv(slope.T @ slope + np.eye(slope.shape[1]) / SLAB**2))
        whitening = self.metric.whitening
        return _covariance(stretches(whitening.channels)[whitening.rows], slope, whole, model)

    @property
    def deviation(self) -> Array:
        """Standard deviations of the fitted values, in their units. Shape (p,)."""
        return np.asarray(np.sqrt(np.maximum(np.diag(self.covariance), 0.0)) * self.fit.size)


def score(channels: Sequence[Channel], fit: Fit, imperfections: Imperfections) -> Scored:
    """The evidence of a fit at the best of the scales that laws may be imperfect by."""
    scored = [_at(channels, fit, imperfections, scale) for scale in IMPERFECT]
    return max(scored, key=lambda s: s.evidence)


def sharp(channels: Sequence[Channel], fit: Fit, imperfections: Imperfections) -> Scored:
    """The same for laws that are as good as they may be: what is missing is not to pass for imperfections when moves
    are looked for.
    """
    return _at(channels, fit, imperfections, min(IMPERFECT))


def _at(channels: Sequence[Channel], fit: Fit, imperfections: Imperfections, scale: float) -> Scored:
    responses = imperfections.responses
    scales = np.full(responses.shape[1], scale)
    left = fit.residual
    for _ in range(PASSES):
        measure = metric(channels, imperfections.facts, rest_of(channels, left), fit.residual, responses, scales)
        taken = measure(fit.residual)[len(measure.whitening.rows) :]
        left = fit.residual - responses @ (scales * taken)
    whole = measure(fit.residual)
    evidence = IMPERFECT[scale] - 0.5 * float(whole @ whole) - measure.determinant
    if len(fit.names):
        slope = measure(fit.slope)
        curvature = slope.T @ slope
        evidence -= 0.5 * float(fit.prior @ fit.prior)
        evidence -= 0.5 * float(np.linalg.slogdet(np.eye(len(curvature)) + SLAB**2 * curvature)[1])
    return Scored(fit, evidence, measure, scale)


def _covariance(number: NDArray[np.int64], slope: Array, whole: Array, model: Array) -> Array:
    """The covariance of fitted values, as the likelihood says or as stretches of the recordings scatter, whichever is
    wider: the sandwich with scores summed over stretches, which are nearly independent (Liang & Zeger 1986).

    Args:
        number: of the stretch of every sample that is looked at. Shape (r,).
        slope: whitened change of the residual per value. Shape (r + q, p).
        whole: whitened residual. Shape (r + q,).
        model: the covariance as the likelihood says. Shape (p, p).
    """
    scores = np.zeros((int(number.max()) + 1, slope.shape[1]))
    np.add.at(scores, number, slope[: len(number)] * whole[: len(number), None])
    few = len(scores) / max(len(scores) - slope.shape[1], 1)
    robust = few * model @ (scores.T @ scores) @ model
    wider = np.sqrt(np.maximum(np.diag(robust), np.diag(model)) / np.diag(model))
    return np.asarray(model * np.outer(wider, wider))


STRETCH = 1.0
"""Samples of one motion within this time [s] are one stretch: several times what lasts in a servo's residual."""


def stretches(channels: Sequence[Channel]) -> NDArray[np.int64]:
    """The number of the stretch that each stacked sample belongs to, all channels of a motion together. Shape (m,)."""
    own = [((c.time - c.time[0]) / STRETCH).astype(np.int64) for c in channels]
    cases = np.repeat([c.case for c in channels], [len(k) for k in own])
    both = np.column_stack([cases, np.concatenate(own)])
    return np.asarray(np.unique(both, axis=0, return_inverse=True)[1].ravel(), dtype=np.int64)
