"""The likelihood of residuals: normal, with a variance for every sample, and how many effective samples they are.

Every sample has the variance of its sensor, its floors (numerics, disturbances) and of what no law explains (the excess
variance). Samples that follow one another are autocorrelated and not as many facts (effective samples): a channel's log
likelihood is divided by the integrated autocorrelation time of its residual, in samples (Sokal 1997; a composite
likelihood with the adjustment of Pauli, Racugno & Ventura 2011). White noise counts in full; a residual that lasts for
0.3 s counts once in 0.3 s.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from realitygap.diagnose.data.problem import Problem, Signals
from realitygap.diagnose.likelihood.floors import Floors
from realitygap.robot.drive import Array

LONGEST = 0.5
"""Samples further apart than this [s] are two facts: a servo's position loop has answered by then."""
FADED = 0.05
"""Autocorrelation below this is noise of its own estimate."""
DENSE = 4.0
"""Samples that are looked at for every fact: what a residual does between them is known from its neighbours."""


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

    @cached_property
    def floor(self) -> Array:
        """The variance of both. Shape (t,)."""
        return np.asarray(self.noise**2 + self.slow**2)


def channels(problem: Problem, floors: Floors, cases: Sequence[int]) -> list[Channel]:
    """The judged channels of some cases, in the order of `stacked`."""
    out = []
    for c in cases:
        case = problem.cases[c]
        for signal in problem.signals(c):
            noise = problem.deviation(signal, floors.noise[c][signal][None, :])[0]
            slow = problem.deviation(signal, floors.slow[c][signal])
            for k in range(slow.shape[1]):
                out.append(Channel(c, signal, k, case.measured.time, float(noise[k]), slow[:, k]))
    return out


def stacked(problem: Problem, cases: Sequence[int], simulated: Sequence[Signals]) -> Array:
    """Simulated minus measured of all channels, one after the other; NaN where nothing was measured. Shape (m,)."""
    parts = [
        problem.delta(c, s, sim).T.ravel() for c, sim in zip(cases, simulated, strict=True) for s in problem.signals(c)
    ]
    return np.concatenate(parts)


def spans(channels: Sequence[Channel]) -> list[tuple[Channel, slice]]:
    """Each channel with where its samples are in what is stacked."""
    ends = np.cumsum([0, *(len(c.time) for c in channels)]).tolist()
    return [(c, slice(a, b)) for c, (a, b) in zip(channels, pairwise(ends), strict=True)]


def effective_fraction(channels: Sequence[Channel], residual: Array) -> Array:
    """How many effective samples (facts) a sample of each channel is: one over the integrated autocorrelation time.

    Shape (channels,).

    Motions of one channel are taken together, so that a short one has not a share of its own.
    """
    found: dict[tuple[str, int], list[float]] = {}
    for channel, span in spans(channels):
        n = len(channel.time)
        part = residual[span] / np.hypot(channel.noise, channel.slow)
        rate = (n - 1) / (channel.time[-1] - channel.time[0])
        lasting = _lasting(part[np.isfinite(part)], int(LONGEST * rate))
        if np.isfinite(part).any():  # a motion in which it was not measured tells nothing of how long it lasts
            found.setdefault(channel.key, []).append(min(lasting, max(LONGEST * rate, 1.0)))
    return np.array([1.0 / np.mean(found.get(c.key, 1.0)) for c in channels])


def _lasting(value: Array, longest: int) -> float:
    """The integrated autocorrelation time of a series in samples, at least 1; about zero, as a gap is no mean."""
    power = float(value @ value)
    total = 1.0
    if power > 0.0:
        for lag in range(1, min(longest, len(value) - 1)):
            rho = float(value[:-lag] @ value[lag:]) / power
            if rho < FADED:
                break
            total += 2.0 * rho
    return total


@dataclass(frozen=True)
class Whitening:
    """Diagonal whitening of what is stacked over channels.

    The squared length of what is whitened is minus twice the log likelihood, beside the determinant.

    Attributes:
        channels: in their order.
        excess: the standard deviation of what no law explains. Shape (channels,).
        effective_fraction: how many effective samples a sample of a channel is. Shape (channels,).
    """

    channels: tuple[Channel, ...]
    excess: Array
    effective_fraction: Array

    def elsewhere(self, channels: Sequence[Channel]) -> Whitening:
        """The same for channels of other motions too: what no law explains there is the mean square of its channel."""
        effective_fraction = {
            c.key: fraction for c, fraction in zip(self.channels, self.effective_fraction, strict=True)
        }
        squares: dict[tuple[str, int], list[float]] = {}
        for c, excess in zip(self.channels, self.excess, strict=True):
            squares.setdefault(c.key, []).append(float(excess) ** 2)
        own = {(c.case, *c.key): excess for c, excess in zip(self.channels, self.excess, strict=True)}
        excess = [own.get((c.case, *c.key), np.sqrt(np.mean(squares[c.key]))) for c in channels]
        return Whitening(tuple(channels), np.array(excess), np.array([effective_fraction[c.key] for c in channels]))

    @cached_property
    def rows(self) -> NDArray[np.int64]:
        """The samples that are looked at, `DENSE` of them for an effective one: the others say the same. Shape (k,)."""
        parts = zip(spans(self.channels), self.every, strict=True)
        return np.concatenate([np.arange(span.start, span.stop, every) for (_, span), every in parts])

    @cached_property
    def parts(self) -> NDArray[np.int64]:
        """The number of the signal of a motion that each of them is of. Shape (k,)."""
        found = list(dict.fromkeys((c.case, c.signal) for c in self.channels))
        return np.repeat([found.index((c.case, c.signal)) for c in self.channels], self.number)

    @cached_property
    def share(self) -> Array:
        """How many effective samples each of them is. Shape (k,)."""
        return np.repeat(self.effective_fraction * self.every, self.number)

    @cached_property
    def variance(self) -> Array:
        """The variance of each of them. Shape (k,)."""
        parts = [
            c.floor[::every] + excess**2
            for c, excess, every in zip(self.channels, self.excess, self.every, strict=True)
        ]
        return np.concatenate(parts)

    @property
    def number(self) -> list[int]:
        """How many samples of each channel are looked at."""
        return [-(-len(c.time) // int(every)) for c, every in zip(self.channels, self.every, strict=True)]

    @cached_property
    def every(self) -> NDArray[np.int64]:
        """Of each channel every so manieth sample is looked at. Shape (channels,)."""
        return np.maximum(1.0 / (DENSE * self.effective_fraction), 1.0).astype(int)

    def __call__(self, columns: Array, weight: Array) -> tuple[Array, float]:
        """Whitened columns of the samples that are looked at, and half the log determinant of their covariance.

        Args:
            columns: NaN where nothing was measured. Shape (m, n).
            weight: trust in each sample: 0 leaves it out. Shape (m,).
        """
        scale, half_log_det = self.scale(weight)
        return self.thinned(columns) * scale[:, None], half_log_det

    def thinned(self, columns: Array) -> Array:
        """Of stacked columns the samples that are looked at, 0 where nothing was measured. Shape (m, n) -> (k, n)."""
        found = columns[self.rows]
        found[~np.isfinite(found)] = 0.0
        return np.asarray(found)

    def scale(self, weight: Array) -> tuple[Array, float]:
        """What each of the samples that are looked at is multiplied by, (k,), and the half log determinant."""
        trust = weight[self.rows]
        good = trust > 0
        half_log_det = 0.5 * float(np.sum(self.share[good] * np.log(self.variance[good] / trust[good])))
        return np.asarray(np.sqrt(self.share * trust / self.variance)), half_log_det
