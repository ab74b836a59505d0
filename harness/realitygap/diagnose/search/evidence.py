"""The evidence of a model: one number for every move of the search.

The log marginal likelihood of the residual, with the fitted values integrated out (the Laplace approximation at the
fit: likelihood, prior and Occam factor), what no law explains estimated for this model, and the discrepancy of each
kind of law marginalised at the scale that the recordings support best (type-II maximum likelihood, MacKay 1992).
"Something else" is thus a model too, the one that has no change and leaves everything to what no law explains: a name
has to beat it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve

from realitygap.diagnose.fit.fit import Fit
from realitygap.diagnose.fit.space import SLAB
from realitygap.diagnose.likelihood.channel_blocks import ChannelBlocks
from realitygap.diagnose.likelihood.excess import excess_deviation
from realitygap.diagnose.likelihood.metric import Metric, marginalised, trusted
from realitygap.diagnose.likelihood.whitening import Channel, Whitening
from realitygap.diagnose.search.discrepancy import Discrepancy
from realitygap.robot.drive import Array

DISCREPANCY_SCALES = {0.125: -6.0, 0.25: -3.0, 0.5: 0.0, 1.0: 0.0, 2.0: 0.0}
"""The scales of the discrepancy of a machine's laws, in multiples of what is ordinary (`law_discrepancy`), with the
logarithm of the prior odds. Laws that are twice as good as a machine's have to be earned by the recordings (20 : 1),
and again."""
APART = 3.0
"""How much less likely it is, in that logarithm, for one kind of law to be twice or half as far off as the others
are (20 : 1, too): what was drawn, measured and looked up with care was so in all its parts. Where each kind could be as
good or poor as it liked, a gain that was 8 % off was a drive twice as far off as any, beside friction and loads that
were as good as may be: of 33 effects of half the ordinary size, 22 stood out, and 31 do with this (29 where laws may be
better by two steps alone). Of 16 machines of nearly right laws that lack nothing one has a false effect that stands
out in a first fit, as before."""
SHARP = 0.25
"""The scale of the discrepancy where moves are looked for: better than a machine's."""
TYPICAL = 0.8
"""The scale of the discrepancy of a typical machine: friction is uneven by 4 to 10 % over angle and direction, and a
torque constant droops by 2 to 5 %, of which the geometric means are 0.79 of what is ordinary (`discrepancy.SHARE`)."""
WORSE = {"load": -3.0}
"""The same of laws that are worse than ordinary, by kind. Friction changes with heat and wear, a drive with its supply;
what a link weighs does not, and a drawing has it to 5 %. Where 8 % had not to be earned, what a carriage that is 10 %
heavier leaves passed for that; and, with laws that are alike, a viscous friction and a rotor's inertia of an STS3215
did (held out 0.073 rad, and 0.032 with this), and held-out gaps of a UR10e were a third wider. Where all kinds had to
be, masses stood in for what its friction is off by: the payload came out 14 % low, with the load alone 0.1 % high."""
SWEEPS = 2
"""How often the scale of each kind of law is chosen beside those of the others."""
PASSES = 2
"""How often what no law explains is estimated anew from what the discrepancy leaves."""

EQUAL = 1.0
"""Models whose evidence differs by less are equal: the simpler one is named."""


@dataclass(frozen=True)
class Scored:
    """A fit with its evidence.

    Attributes:
        fit: the model.
        evidence: of it.
        metric: in which it was found.
        discrepancy_scale: how many times the ordinary discrepancy each kind of law has in it.
        left: what this discrepancy leaves of the residual. Shape (m,).
        away: how far the values are from those that are likeliest where laws are so far off, in sizes, where that was
            simulated. Shape (p,).
    """

    fit: Fit
    evidence: float
    metric: Metric
    discrepancy_scale: Mapping[str, float]
    left: Array
    away: Array | None = None

    @cached_property
    def covariance(self) -> Array:
        """Of the values that are likeliest where laws are off, in sizes², as the likelihood says or as stretches
        of the recordings scatter (a sandwich), whichever is wider. Shape (p, p).
        """
        if not len(self.fit.names):
            return np.zeros((0, 0))
        whitening = self.metric.whitening
        return _covariance(stretches(whitening.channels)[whitening.rows], *self._white, self.laplace_covariance)

    @cached_property
    def laplace_covariance(self) -> Array:
        """The same as the likelihood says, in the Laplace approximation of which evidence is made. Shape (p, p).

        The inverse of the Gauss-Newton Hessian plus the precision of the prior.
        """
        slope, _ = self._white
        return np.asarray(np.linalg.inv(slope.T @ slope + np.eye(slope.shape[1]) / SLAB**2))

    @property
    def deviation(self) -> Array:
        """How far the fitted values may be off in root mean square, in their units. Shape (p,).

        Values are told as if laws were exact. What laws are off by draws them away from those that are likeliest: as
        far as these are, or by one Gauss-Newton step there.
        """
        if not len(self.fit.names):
            return np.zeros(0)
        away = self._step if self.away is None else self.away
        return np.asarray(np.sqrt(np.maximum(np.diag(self.covariance), 0.0) + away**2) * self.fit.size)

    @property
    def _step(self) -> Array:
        """A Gauss-Newton step to the likeliest values, in sizes. Shape (p,)."""
        slope, whole = self._white
        prior = np.eye(slope.shape[1]) / SLAB
        return np.asarray(np.linalg.lstsq(np.vstack([slope, prior]), np.pad(whole, (0, len(prior))))[0])

    @cached_property
    def _white(self) -> tuple[Array, Array]:
        """The slopes and the residual in the metric. Shapes (r, p), (r,)."""
        return self.metric(self.fit.slope), self.metric(self.fit.residual)


def score(channels: Sequence[Channel], fit: Fit, discrepancy: Discrepancy) -> Scored:
    """The evidence of a fit at the best of the scales that the discrepancy of each kind of law may have."""
    return _at(_first(channels, fit, discrepancy), tuple(DISCREPANCY_SCALES), discrepancy.most)


def cautious(channels: Sequence[Channel], fit: Fit, discrepancy: Discrepancy) -> Scored:
    """The same for laws that are ordinary at best: intervals are told so. That laws look better in a few motions is no
    promise for the machine's other motions, which the values are for.
    """
    return _at(_first(channels, fit, discrepancy), tuple(scale for scale in DISCREPANCY_SCALES if scale >= 1.0))


def ordinary(channels: Sequence[Channel], fit: Fit, discrepancy: Discrepancy) -> Scored:
    """The same for laws that are as far off as a typical machine's, whatever recordings say."""
    return _at(_first(channels, fit, discrepancy), (TYPICAL,))


def sharp(channels: Sequence[Channel], fit: Fit, discrepancy: Discrepancy) -> Scored:
    """The same for laws that are better than a machine's: what is missing is not to pass for discrepancy when moves
    are looked for.
    """
    return _at(_first(channels, fit, discrepancy), (SHARP,))


def scored_and_sharp(channels: Sequence[Channel], fit: Fit, discrepancy: Discrepancy) -> tuple[Scored, Scored]:
    """Both `score` and `sharp`, which begin alike."""
    first = _first(channels, fit, discrepancy)
    return _at(first, tuple(DISCREPANCY_SCALES), discrepancy.most), _at(first, (SHARP,))


@dataclass(frozen=True)
class _Look:
    """A fit in the metric of what a residual leaves.

    Attributes:
        fit: the model.
        discrepancy: of all models of a round.
        shares: how much of each of its responses counts for the fit. Shape (q,).
        whitening: what no law explains, of the residual.
        weight: trust in every stacked sample. Shape (m,).
        scale: what the samples that are looked at are multiplied by. Shape (k,).
        determinant: half the logarithm of the covariance's.
        thin: the residual, its p slopes and q responses of the discrepancy in these samples, (k, 1 + p + q).
        log_evidence: of the model, by the scales of the discrepancy.
    """

    fit: Fit
    discrepancy: Discrepancy
    shares: Array
    whitening: Whitening
    weight: Array
    scale: Array
    half_log_det: float
    thin: ChannelBlocks
    log_evidence: _LogEvidence

    def again(self, left: Array) -> _Look:
        """The same in the metric of another residual. Shape (m,)."""
        return _look(self.whitening.channels, self.fit, self.discrepancy, left, self.thin)


def _first(channels: Sequence[Channel], fit: Fit, discrepancy: Discrepancy) -> _Look:
    """A fit in the metric of what it leaves itself."""
    return _look(channels, fit, discrepancy, fit.residual)


def _look(
    channels: Sequence[Channel], fit: Fit, discrepancy: Discrepancy, left: Array, thin: ChannelBlocks | None = None
) -> _Look:
    whitening, weight = trusted(
        channels, discrepancy.effective_fraction, excess_deviation(channels, discrepancy.effective_fraction, left), left
    )
    if thin is None:
        own = np.column_stack([fit.residual, fit.slope.reshape(len(left), -1)])
        thin = ChannelBlocks.of(whitening.thinned(own), whitening.number).beside(discrepancy.thinned(whitening))
    scale, half_log_det = whitening.scale(weight)
    shares = discrepancy.shares(fit)
    columns = np.concatenate([np.ones(thin.width - len(shares)), shares])
    log_evidence = _LogEvidence(thin.scaled(scale).gram() * np.outer(columns, columns), discrepancy.laws)
    return _Look(fit, discrepancy, shares, whitening, weight, scale, half_log_det, thin, log_evidence)


def _at(look: _Look, scales: Sequence[float], most: Mapping[str, float] = MappingProxyType({})) -> Scored:
    fit, discrepancy, shares = look.fit, look.discrepancy, look.shares

    def best(look: _Look) -> tuple[dict[str, float], Array, Array]:
        chosen = look.log_evidence.best(scales, most)
        each = np.array([chosen[law] for law in discrepancy.laws])
        return (
            chosen,
            each,
            fit.residual - discrepancy.times(shares * look.log_evidence.taken(each), look.whitening.channels),
        )

    chosen, each, left = best(look)
    for _ in range(PASSES - 1 if discrepancy.laws else 0):
        look = look.again(left)
        chosen, each, left = best(look)
    evidence = look.log_evidence(chosen) - look.half_log_det - 0.5 * float(fit.prior @ fit.prior)
    taken = discrepancy.thinned(look.whitening).scaled(look.scale).stretched(shares * each)
    metric = marginalised(look.whitening, look.weight, taken, look.half_log_det, look.log_evidence.factor(each))
    return Scored(fit, evidence, metric, chosen, left)


def log_prior(chosen: Mapping[str, float]) -> float:
    """The logarithm of the prior odds for the discrepancy of each kind of law having this scale."""
    worse = sum(WORSE.get(law, 0.0) for law, scale in chosen.items() if scale > 1.0)
    octaves = np.log2(list(chosen.values()))
    alike = (
        prior - APART * float(np.abs(octaves - np.log2(scale)).sum()) for scale, prior in DISCREPANCY_SCALES.items()
    )
    return worse + max(alike)


class _LogEvidence:
    """The log evidence of a model as a function of the scales of its law discrepancy, from one Gram matrix.

    Normal in closed form, with the discrepancy marginalised by the Woodbury identity and the matrix determinant lemma.

    Args:
        gram: inner products of the whitened residual, its p slopes and the q responses. Shape (1 + p + q, 1 + p + q).
        laws: the kind of law of every response.
    """

    def __init__(self, gram: Array, laws: Sequence[str]) -> None:
        self.gram, self.laws, self.model = gram, laws, len(gram) - len(laws)

    def best(self, scales: Sequence[float], most: Mapping[str, float]) -> dict[str, float]:
        """The scale of each kind of law, at `most` so much, that makes the recordings most probable: the best that all
        have, then one kind after the other (coordinate ascent).
        """
        known: dict[tuple[float, ...], float] = {}  # where a sweep changes little, the next asks much the same

        def log_evidence(tried: Mapping[str, float]) -> float:
            at = tuple(tried.values())
            if at not in known:
                known[at] = self(tried)
            return known[at]

        def capped(law: str, scale: float) -> float:
            return min(scale, most.get(law, scale))

        chosen = max(({law: capped(law, scale) for law in self.laws} for scale in scales), key=log_evidence)
        for _ in range(SWEEPS if len(scales) > 1 else 0):
            for law in chosen:
                chosen = max(({**chosen, law: capped(law, scale)} for scale in scales), key=log_evidence)
        return chosen

    def taken(self, each: Array) -> Array:
        """The posterior mean of how far each law is off, in its responses, where each may be off by so much. (q,)."""
        factor, right = self._solved(each)
        return np.asarray(each * cho_solve(factor, right[:, 0])) if len(each) else each

    def __call__(self, chosen: Mapping[str, float]) -> float:
        each, model = np.array([chosen[law] for law in self.laws]), self.gram[: self.model, : self.model]
        value = log_prior(chosen)
        if len(each):
            factor, right = self._solved(each)
            model = model - right.T @ cho_solve(factor, right)
            value -= float(np.sum(np.log(np.diag(factor[0]))))
        curvature = model[1:, 1:]
        occam = 0.5 * float(np.linalg.slogdet(np.eye(len(curvature)) + SLAB**2 * curvature)[1])
        return value - 0.5 * float(model[0, 0]) - occam

    def factor(self, each: Array) -> tuple[Array, bool]:
        """The Cholesky factor of 1 + ΦᵀΦ, where Φ is what laws do that are off by so much. Shape (q, q)."""
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
