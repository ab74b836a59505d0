"""The evidence of a model: one number for every move of the search.

The marginal likelihood of the residual, with the fitted values integrated out (Laplace), what no law explains estimated
for this model, and imperfections of each kind of law marginalised at the scale that the recordings support best
(type-II maximum likelihood, MacKay 1992). "Something else" is thus a model too, the one that has no change and leaves
everything to what no law explains: a name has to beat it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve

from realitygap.diagnose.fit.fit import Fit
from realitygap.diagnose.fit.space import SLAB
from realitygap.diagnose.likelihood.metric import Metric, marginalised, rest_of, trusted
from realitygap.diagnose.likelihood.whitening import Channel
from realitygap.diagnose.search.imperfections import Imperfections
from realitygap.robot.drive import Array

IMPERFECT = {0.25: -3.0, 0.5: 0.0, 1.0: 0.0, 2.0: 0.0}
"""How imperfect the laws of a kind are, in multiples of what is ordinary (`imperfections`), with the logarithm of the
odds beforehand. Better laws than a machine's have to be earned by the recordings (20 : 1)."""
SWEEPS = 2
"""How often the scale of each kind of law is chosen beside those of the others."""
PASSES = 2
"""How often what no law explains is estimated anew from what the imperfections leave."""

EQUAL = 1.0
"""Models whose evidence differs by less are equal: the simpler one is named."""


@dataclass(frozen=True)
class Scored:
    """A fit with its evidence.

    Attributes:
        fit: the model.
        evidence: of it.
        metric: in which it was found.
        imperfect: how imperfect each kind of law is in it.
        left: what these imperfections leave of the residual. Shape (m,).
        away: how far the values are from those that are likeliest where laws are so imperfect, in sizes, where that was
            simulated. Shape (p,).
    """

    fit: Fit
    evidence: float
    metric: Metric
    imperfect: Mapping[str, float]
    left: Array
    away: Array | None = None

    @cached_property
    def covariance(self) -> Array:
        """Of the values that are likeliest where laws are imperfect, in sizes². Shape (p, p)."""
        if not len(self.fit.names):
            return np.zeros((0, 0))
        slope, whole = self._white
        model = np.asarray(np.linalg.inv(slope.T @ slope + np.eye(slope.shape[1]) / SLAB**2))
        whitening = self.metric.whitening
        return _covariance(stretches(whitening.channels)[whitening.rows], slope, whole, model)

    @property
    def deviation(self) -> Array:
        """How far the fitted values may be off in root mean square, in their units. Shape (p,).

        Values are told as if laws were exact. What laws are off by draws them away from those that are likeliest: as
        far as these are, or by one straight step there.
        """
        if not len(self.fit.names):
            return np.zeros(0)
        away = self._step if self.away is None else self.away
        return np.asarray(np.sqrt(np.maximum(np.diag(self.covariance), 0.0) + away**2) * self.fit.size)

    @property
    def _step(self) -> Array:
        """A straight step to the likeliest values, in sizes. Shape (p,)."""
        slope, whole = self._white
        prior = np.eye(slope.shape[1]) / SLAB
        return np.asarray(np.linalg.lstsq(np.vstack([slope, prior]), np.pad(whole, (0, len(prior))))[0])

    @cached_property
    def _white(self) -> tuple[Array, Array]:
        """The slopes and the residual in the metric. Shapes (r, p), (r,)."""
        return self.metric(self.fit.slope), self.metric(self.fit.residual)


def score(channels: Sequence[Channel], fit: Fit, imperfections: Imperfections) -> Scored:
    """The evidence of a fit at the best of the scales that each kind of law may be imperfect by."""
    return _at(channels, fit, imperfections, tuple(IMPERFECT))


def cautious(channels: Sequence[Channel], fit: Fit, imperfections: Imperfections) -> Scored:
    """The same for laws that are ordinary at best: intervals are told so. That laws look better in a few motions is no
    promise for the machine's other motions, which the values are for.
    """
    return _at(channels, fit, imperfections, tuple(scale for scale in IMPERFECT if scale >= 1.0))


def sharp(channels: Sequence[Channel], fit: Fit, imperfections: Imperfections) -> Scored:
    """The same for laws that are as good as they may be: what is missing is not to pass for imperfections when moves
    are looked for.
    """
    return _at(channels, fit, imperfections, (min(IMPERFECT),))


def _at(channels: Sequence[Channel], fit: Fit, imperfections: Imperfections, scales: Sequence[float]) -> Scored:
    shares, left = imperfections.shares(fit), fit.residual
    columns = [left[:, None], fit.slope.reshape(len(left), -1)]
    thin: Array | None = None
    for _ in range(PASSES if imperfections.laws else 1):
        rest = rest_of(channels, imperfections.facts, left)
        whitening, weight = trusted(channels, imperfections.facts, rest, left)
        if thin is None:
            thin = np.hstack([*map(whitening.thinned, columns), imperfections.thinned(whitening) * shares])
        white, determinant = whitening.scaled(thin, weight)
        odds = _Odds(white.T @ white, imperfections.laws)
        chosen = odds.best(scales)
        each = np.array([chosen[law] for law in imperfections.laws])
        left = fit.residual - imperfections.responses @ (shares * odds.taken(each))
    evidence = odds(chosen) - determinant - 0.5 * float(fit.prior @ fit.prior)
    taken = white[:, white.shape[1] - len(each) :] * each
    metric = marginalised(whitening, weight, taken, determinant, odds.factor(each))
    return Scored(fit, evidence, metric, chosen, left)


class _Odds:
    """The logarithm of a model's likelihood as a function of how imperfect laws are.

    Args:
        gram: inner products of the whitened residual, its p slopes and the q responses. Shape (1 + p + q, 1 + p + q).
        laws: the kind of law of every response.
    """

    def __init__(self, gram: Array, laws: Sequence[str]) -> None:
        self.gram, self.laws, self.model = gram, laws, len(gram) - len(laws)

    def best(self, scales: Sequence[float]) -> dict[str, float]:
        """The scale of each kind of law that makes the recordings most probable, one kind after the other."""
        chosen = dict.fromkeys(self.laws, scales[len(scales) // 2])
        for _ in range(SWEEPS if len(scales) > 1 else 0):
            for law in chosen:
                chosen[law] = max(scales, key=lambda scale: self({**chosen, law: scale}))
        return chosen

    def taken(self, each: Array) -> Array:
        """How far each law is off, in its responses, where each may be off by so much. Shape (q,)."""
        factor, right = self._solved(each)
        return np.asarray(each * cho_solve(factor, right[:, 0])) if len(each) else each

    def __call__(self, chosen: Mapping[str, float]) -> float:
        each, model = np.array([chosen[law] for law in self.laws]), self.gram[: self.model, : self.model]
        odds = sum(IMPERFECT[scale] for scale in chosen.values())
        if len(each):
            factor, right = self._solved(each)
            model = model - right.T @ cho_solve(factor, right)
            odds -= float(np.sum(np.log(np.diag(factor[0]))))
        curvature = model[1:, 1:]
        occam = 0.5 * float(np.linalg.slogdet(np.eye(len(curvature)) + SLAB**2 * curvature)[1])
        return odds - 0.5 * float(model[0, 0]) - occam

    def factor(self, each: Array) -> tuple[Array, bool]:
        """The Cholesky factor of what imperfections add to a unit matrix. Shape (q, q)."""
        inner = self.gram[self.model :, self.model :] * np.outer(each, each) + np.eye(len(each))
        return cho_factor(inner, lower=True) if len(each) else (inner, True)

    def _solved(self, each: Array) -> tuple[tuple[Array, bool], Array]:
        """That, and their products with residual and slopes."""
        return self.factor(each), each[:, None] * self.gram[self.model :, : self.model]


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
