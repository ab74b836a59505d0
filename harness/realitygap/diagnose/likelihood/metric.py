"""The metric of residuals: whitened, and with a small discrepancy of every law on the list marginalised.

No law is exact: beside what is missing, everything on the list is wrong by a little. Each discrepancy is a multiple of
an effect's response with a normal prior of a common scale, so that the covariance of a residual is the diagonal one of
noise and what lasts, plus Φ·diag(scale²)·Φᵀ of low rank, inverted by the Woodbury identity (Kennedy & O'Hagan 2001,
with the discrepancy spanned by known laws). A parameter that a discrepancy could mimic gets a wider interval, and a
small effect that mends the law of a large one gains nothing.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from realitygap.diagnose.likelihood.channel_blocks import ChannelBlocks
from realitygap.diagnose.likelihood.whitening import Channel, Whitening
from realitygap.robot.drive import Array

OUTLIER = 3.0
"""An innovation beyond this many times their root mean square is trusted less (Cauchy; 0.3 % of normal ones are)."""


@dataclass(frozen=True)
class Metric:
    """Turns stacked residuals and responses into vectors whose squared length is their squared Mahalanobis distance.

    Under the covariance Σ, which is diagonal, plus ΦΦᵀ in whitened samples.

    Attributes:
        whitening: noise and what lasts.
        weight: trust in every stacked sample, 0 where nothing was measured. Shape (m,).
        discrepancy: whitened responses times their scale, (r, q).
        factor: Cholesky factor of 1 + ΦᵀΦ of these.
        half_log_det: half the logarithm of the covariance's determinant.
    """

    whitening: Whitening
    weight: Array
    discrepancy: ChannelBlocks
    factor: tuple[Array, bool]
    half_log_det: float

    def __call__(self, columns: Array) -> Array:
        """Shape (m, k) or (m,) -> (r + q, k) or (r + q,): what is left of the samples that are looked at, and the
        amounts of the discrepancy that were taken (their posterior mean). The sum of both squared lengths is that under
        the precision Σ⁻¹, by the Woodbury identity.
        """
        one = columns.ndim == 1
        white, _ = self.whitening(columns.reshape(len(columns), -1), self.weight)
        taken = cho_solve(self.factor, self.discrepancy.on(white))
        out = np.vstack([white - self.discrepancy.times(taken), taken])
        return out[:, 0] if one else out

    def seen(self, change: Array) -> float:
        """How many standard deviations of all samples together a change of the residual is, were laws exact. (m,)."""
        white, _ = self.whitening(np.nan_to_num(change)[:, None], self.weight)
        return float(np.linalg.norm(white))

    def gram(self, columns: Sequence[Array]) -> Array:
        """The Gram matrix Xᵀ·Σ⁻¹·X of columns, each (m,) or (m, k), under the precision: the inner products of what a
        call gives, in less time where they are zero in most channels. Shape (n, n), where n are all columns.
        """
        thin = np.hstack([self.whitening.thinned(c.reshape(len(c), -1)) for c in columns])
        n, (scale, _) = thin.shape[1], self.whitening.scale(self.weight)
        white = ChannelBlocks.of(thin, self.whitening.number).scaled(scale)
        both = white.beside(self.discrepancy).gram()
        return np.asarray(both[:n, :n] - both[:n, n:] @ cho_solve(self.factor, both[n:, :n]))


def trusted(
    channels: Sequence[Channel], effective_fraction: Array, excess: Array, residual: Array
) -> tuple[Whitening, Array]:
    """The whitening for what a residual leaves, and the trust in every stacked sample (m,): outliers count less.

    By the weights of a robust (Cauchy) likelihood, as in iteratively reweighted least squares.

    Args:
        channels: of the stacked residual.
        effective_fraction: how many effective samples a sample of each channel is. Shape (channels,).
        excess: the standard deviation of what no law explains. Shape (channels,).
        residual: of the model as it stands, which says what is missing and what is an outlier. Shape (m,).
    """
    whitening = Whitening(tuple(channels), excess, effective_fraction)
    finite = np.isfinite(residual).astype(float)
    rows = whitening.rows
    white, _ = whitening(residual[:, None], finite)
    size = np.abs(white[:, 0])
    spread = math.sqrt(float(np.mean(size[finite[rows] > 0] ** 2))) if finite[rows].any() else 1.0
    spread = max(spread, 1e-12)
    weight = finite
    weight[rows] = finite[rows] / (1.0 + (size / (OUTLIER * spread)) ** 2)
    return whitening, weight


def marginalised(
    whitening: Whitening,
    weight: Array,
    discrepancy: ChannelBlocks,
    half_log_det: float,
    factor: tuple[Array, bool] | None = None,
) -> Metric:
    """The metric with the discrepancy marginalised: what it could do counts for little.

    Args:
        whitening: noise and what lasts.
        weight: trust in every stacked sample. Shape (m,).
        discrepancy: whitened responses of laws that are off by one standard deviation, (r, q).
        half_log_det: that of what lasts and of noise. The discrepancy adds its own, by the matrix determinant lemma.
        factor: the Cholesky factor of 1 + ΦᵀΦ of these, where it is known.
    """
    if not discrepancy.width:
        return Metric(whitening, weight, discrepancy, (np.zeros((0, 0)), True), half_log_det)
    if factor is None:
        factor = cho_factor(np.eye(discrepancy.width) + discrepancy.gram(), lower=True)
    half_log_det += float(np.sum(np.log(np.diag(factor[0]))))
    return Metric(whitening, weight, discrepancy, factor, half_log_det)
