"""How well each joint's position follows each command, through the simplest thing that a servo is: a lag and a gain.

position = slope·command(t - delay, low-passed) + intercept, fitted by least squares over a grid of delays and low-pass
times, for every pair of a command and a position.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from realitygap.check.observed import Observed
from realitygap.check.servo import slowness
from realitygap.recording.faults import low_pass
from realitygap.trace.trace import Array

DELAYS = np.arange(0.0, 0.2501, 0.025)
"""s: a bus and a servo's own queue; what is a quarter of a second late was stamped by another clock."""
LAGS = (0.0, 0.03, 0.1, 0.3, 1.0)
"""s: first-order lags of servos, stiff to weak."""
WEAK = 5.0
"""A servo may be this much slower than its numbers say: a gain at a fifth, or five times the viscous friction."""

LEAST = 0.02
"""s: a servo lags by its own sampling and friction, too."""
EXPLAINED = 0.9
"""The share of a position's variance that its command explains through a lag and a gain: 0.91 to 1 was measured on five
machines, weak, saturated and rate-limited ones among them."""

OFTEN = 0.4
"""The share of the time that a command must be in force to be judged."""


@dataclass(frozen=True)
class Following:
    """Fits of every position (column) by every command (row). All Shape (n, n).

    Attributes:
        share: of the position's variance that the command explains; NaN where either does not move.
        slope: position per command.
        intercept: [rad or m].
        late: delay and lag of the best fit together [s].
    """

    share: Array
    slope: Array
    intercept: Array
    late: Array


def following(
    command: Array,
    position: Array,
    step: float,
    *,
    delays: Sequence[float] | Array = DELAYS,
    lags: Sequence[float] = LAGS,
    edges: bool = True,
) -> tuple[Following, Following]:
    """The best fit of every position by every command: with a slope of either sign, and with a positive one.

    Args:
        command: NaN where there is none. Shape (k, n).
        position: Shape (k, n).
        step: spacing of the samples [s].
        delays: that are tried [s]; with negative ones the position moves first.
        lags: low-pass times that are tried [s].
        edges: whether the first command holds before it, as at the start of a recording; otherwise such samples are
            left out.
    """
    n = position.shape[1]
    either, along = (Following(*(np.full((n, n), np.nan) for _ in range(4))) for _ in range(2))
    for best in (either, along):
        best.share[:] = -np.inf
    on, held = np.isfinite(command).astype(float), _filled(command)
    q = position - position.mean(axis=0)
    for lag in lags:
        filtered = np.column_stack([low_pass(column, lag, step) for column in held.T])
        for delay in delays:
            index = np.arange(len(q)) - round(float(delay) / step)
            inside = (index >= 0) & (index < len(q))
            index = np.clip(index, 0, len(q) - 1)
            known = on[index] if edges else on[index] * inside[:, None]
            share, slope, intercept = _fits(filtered[index], known, q)
            _keep(either, share, slope, intercept, float(delay) + lag)
            backwards = slope < 0
            _keep(
                along, np.where(backwards, 0.0, share), np.where(backwards, 0.0, slope), intercept, float(delay) + lag
            )
    for best in (either, along):
        best.share[np.isinf(best.share)] = np.nan
        best.intercept[:] += position.mean(axis=0)
    return either, along


def slowest(o: Observed) -> float:
    """The slowest first-order lag [s] that a servo of this robot may have: `WEAK` times what its numbers say."""
    lag = slowness(o)[o.follows]
    return WEAK * float(np.max(lag[np.isfinite(lag)], initial=LEAST))


def _fits(c: Array, known: Array, q: Array) -> tuple[Array, Array, Array]:
    """Share, slope and intercept of all pairs at one delay and lag; a share of -inf where nothing can be said."""
    count = np.maximum(known.sum(axis=0), 1.0)[:, None]
    c = np.where(known > 0, c, 0.0)
    sum_c, sum_q, squares = c.sum(axis=0)[:, None], known.T @ q, (c * c).sum(axis=0)[:, None]
    var_c, var_q = squares - sum_c**2 / count, known.T @ (q * q) - sum_q**2 / count
    both = c.T @ q - sum_c * sum_q / count
    told = (var_c > 1e-9 * squares) & (var_q > 0) & (count > OFTEN * len(q))
    with np.errstate(divide="ignore", invalid="ignore"):
        slope = np.where(told, both / var_c, np.nan)
        share = np.where(told, both**2 / (var_c * var_q), -np.inf)
    return share, slope, (sum_q - slope * sum_c) / count


def _keep(best: Following, share: Array, slope: Array, intercept: Array, late: float) -> None:
    """Keep the fits that are better than the best so far."""
    better = share > best.share
    for kept, value in zip(
        (best.share, best.slope, best.intercept, best.late),
        (share, slope, intercept, np.full_like(share, late)),
        strict=True,
    ):
        kept[better] = value[better]


def _filled(command: Array) -> Array:
    """A command whose gaps hold the last value, so that it can be filtered; before the first, the first one."""
    out = command.copy()
    for column in out.T:
        known = np.isfinite(column)
        if not known.any():
            column[:] = 0.0
            continue
        first = int(np.argmax(known))
        column[:] = column[np.maximum.accumulate(np.where(known, np.arange(len(column)), first))]
    return out
