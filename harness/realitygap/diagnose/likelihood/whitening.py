"""The likelihood of residuals: white noise of the sensor plus something that lasts, for every judged channel.

A residual is e + u with e white, of the sensor's standard deviation, and u an Ornstein-Uhlenbeck process: what numerics,
disturbances and imperfect laws do lasts for a correlation time. A Kalman filter turns the residual into innovations that
are independent and of unit variance, exactly and in one pass (Harvey, Forecasting, Structural Time Series Models and the
Kalman Filter, 1989, section 3.4). Whatever is linear in the residual, such as the response to an effect, is whitened by
the same filter.
"""
# mypy: allow-untyped-defs
# (the compiled function takes arrays and numbers only; its callers are typed)

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numba import njit

from realitygap.diagnose.data.case import JOINT_SIGNALS
from realitygap.diagnose.data.problem import Problem, Signals
from realitygap.diagnose.data.push import CORRELATION
from realitygap.diagnose.likelihood.floors import Floors
from realitygap.robot.drive import Array

LASTING = 0.5
"""What lasts is at least this share of the sensor's noise: rounding is the same as long as a joint rests, and a floor of
1 is what cannot be told from a perfect model."""


@dataclass(frozen=True)
class Channel:
    """One signal of one joint (or axis of the base) in one motion.

    `noise` is the standard deviation of the sensor, `slow` that of what lasts (t,).
    """

    case: int
    signal: str
    column: int
    time: Array
    noise: float
    slow: Array

    @property
    def key(self) -> tuple[str, int]:
        """Which channel it is, in whatever motion."""
        return self.signal, self.column


Rest = dict[tuple[str, int], float]
"""The standard deviation of what no law explains, by channel: the same in all motions."""


def channels(problem: Problem, floors: Floors, cases: Sequence[int]) -> list[Channel]:
    """The judged channels of some cases, in the order of `stacked`."""
    out = []
    for c in cases:
        case = problem.cases[c]
        for signal in problem.signals(c):
            noise = floors.noise[c][signal]
            noise = noise[problem.judged] if signal in JOINT_SIGNALS else noise
            slow = problem.columns(signal, floors.slow[c][signal])
            for k in range(slow.shape[1]):
                out.append(Channel(c, signal, k, case.measured.time, float(noise[k]), slow[:, k]))
    return out


def stacked(problem: Problem, cases: Sequence[int], simulated: Sequence[Signals]) -> Array:
    """Simulated minus measured of all channels, one after the other; NaN where nothing was measured. Shape (m,)."""
    parts = [problem.delta(c, s, sim).T.ravel() for c, sim in zip(cases, simulated, strict=True) for s in problem.signals(c)]
    return np.concatenate(parts)


@dataclass(frozen=True)
class Whitening:
    """Whitens what is stacked over channels. `determinant` is ½·ln of the determinant of the covariance."""

    channels: tuple[Channel, ...]
    rest: Rest

    def __call__(self, columns: Array, finite: Array) -> tuple[Array, float]:
        """Innovations of stacked columns, and half the logarithm of the determinant of their covariance.

        Args:
            columns: Shape (m, k); what is not finite in the first column counts nothing in any.
            finite: Shape (m,), the weight of each sample: 0 leaves it out, less than 1 trusts it less.
        """
        out = np.empty_like(columns)
        determinant, at = 0.0, 0
        for channel in self.channels:
            n = len(channel.time)
            lasting = np.sqrt(
                channel.slow**2 + (LASTING * channel.noise) ** 2 + self.rest.get(channel.key, 0.0) ** 2
            )
            determinant += _innovations(
                channel.time, channel.noise, lasting, finite[at : at + n], columns[at : at + n], out[at : at + n], CORRELATION
            )
            at += n
        return out, determinant


@njit(cache=True)
def _innovations(time, noise, lasting, weight, columns, out, correlation):
    """Fill `out` with the innovations of columns (t, k); half the logarithm of the determinant."""
    k = columns.shape[1]
    mean = np.zeros(k)
    variance, logarithm = 1.0, 0.0
    for i in range(len(time)):
        if i > 0:
            keep = np.exp(-(time[i] - time[i - 1]) / correlation)
            variance = keep * keep * variance + 1.0 - keep * keep
            for j in range(k):
                mean[j] *= keep
        if weight[i] <= 0.0:
            for j in range(k):
                out[i, j] = 0.0
            continue
        a = lasting[i]
        total = a * a * variance + noise * noise / weight[i]
        root = np.sqrt(total)
        gain = variance * a / total
        for j in range(k):
            innovation = columns[i, j] - a * mean[j]
            out[i, j] = innovation / root
            mean[j] += gain * innovation
        variance -= gain * a * variance
        logarithm += np.log(root)
    return logarithm
