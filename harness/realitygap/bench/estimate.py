"""A number with its 95 % interval, and the jackknife that gives intervals to fits without a closed form."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy import stats

Array = NDArray[np.float64]
Block = TypeVar("Block")


@dataclass(frozen=True)
class Estimate:
    """A value and its 95 % confidence interval; the interval may be infinite or, where nothing is known, NaN."""

    value: float
    low: float
    high: float

    def text(self, digits: int = 2) -> str:
        """The value with its interval, `4.00 [3.81, 4.19]`."""
        if np.isnan(self.low) or np.isnan(self.high):
            return f"{self.value:.{digits}f} [unknown]"
        return f"{self.value:.{digits}f} [{self.low:.{digits}f}, {self.high:.{digits}f}]"

    def scaled(self, factor: float) -> "Estimate":
        """The estimate in another unit."""
        low, high = sorted((self.low * factor, self.high * factor))
        return Estimate(self.value * factor, low, high)

    @property
    def half_width(self) -> float:
        """Half of the interval."""
        return (self.high - self.low) / 2


def mean(values: Array) -> Estimate:
    """The mean of independent values with Student's interval; NaN bounds for a single one."""
    center = float(np.mean(values))
    if len(values) < 2:
        return Estimate(center, np.nan, np.nan)
    half = float(stats.t.ppf(0.975, len(values) - 1) * np.std(values, ddof=1) / np.sqrt(len(values)))
    return Estimate(center, center - half, center + half)


def jackknife(blocks: Sequence[Block], fit: Callable[[Sequence[Block]], Array]) -> list[Estimate]:
    """Every parameter of a fit with the interval of the delete-one-block jackknife (Efron and Stein 1981).

    The blocks must be what is independent (recordings, or swings), not samples, whose noise is correlated.
    """
    n = len(blocks)
    whole = fit(blocks)
    if n < 2:
        return [Estimate(float(v), np.nan, np.nan) for v in whole]
    parts = np.array([fit([b for j, b in enumerate(blocks) if j != i]) for i in range(n)])
    error = np.sqrt((n - 1) / n * np.sum((parts - parts.mean(axis=0)) ** 2, axis=0))
    half = stats.t.ppf(0.975, n - 1) * error
    return [Estimate(float(v), float(v - h), float(v + h)) for v, h in zip(whole, half, strict=True)]
