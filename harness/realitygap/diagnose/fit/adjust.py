"""A quick fit: from a fitted model to one that has a change more, less, or another, by a few Gauss-Newton steps.

What the values that both have in common do to the traces is taken from the fitted model; only what is new is simulated
for its derivative. It tells which models are worth a fit.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from realitygap.diagnose.data.changes import Change
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.fit.fit import Fit, Space, slope
from realitygap.diagnose.fit.responses import residual
from realitygap.diagnose.likelihood.metric import Metric
from realitygap.robot.drive import Array

STEPS = 2
"""Steps at most."""
SHORTER = (1.0, 0.4)
"""Shares of a step that are tried."""


def adjust(
    simulations: Simulations,
    known: Fit,
    changes: Sequence[Change],
    train: Sequence[int],
    metric: Metric,
    coarse: Sequence[float],
) -> Fit | None:
    """Changes with their values near the best; None where they cannot be simulated.

    Args:
        simulations: of the problem.
        known: a fitted model that shares values with the changes.
        changes: with first guesses.
        train: cases to fit to.
        metric: of the stacked residual.
        coarse: the least faithful share of the step rate, by case, for derivatives.
    """
    space = Space(simulations.problem, changes)
    now = residual(simulations, changes, train)
    if now is None:
        return None
    x = space.first
    slopes = _slopes(simulations, known, space, x, train, coarse) if len(x) else np.zeros((len(now), 0))
    cost = _cost(metric, space, x, now)
    low, high = space.bounds()
    for _ in range(STEPS if len(x) else 0):
        white = metric(np.column_stack([now, slopes]))
        curve = white[:, 1:].T @ white[:, 1:] + np.diag(space.prior_slope(x) ** 2)
        step = np.linalg.solve(curve, -white[:, 1:].T @ white[:, 0] - space.prior(x) * space.prior_slope(x))
        for share in SHORTER:
            moved = np.clip(x + share * step, low, high)
            there = residual(simulations, space.at(moved), train)
            if there is not None and (lower := _cost(metric, space, moved, there)) < cost:
                gain, x, now, cost = cost - lower, moved, there, lower
                break
        else:
            break
        if gain < 1.0:
            break
    return Fit(space.at(x), now, space.names, slopes, space.scale, space.prior(x))


def _cost(metric: Metric, space: Space, x: Array, residual: Array) -> float:
    """Minus twice the logarithm of the posterior density, beside a constant."""
    return float(np.sum(metric(residual) ** 2) + np.sum(space.prior(x) ** 2))


def _slopes(
    simulations: Simulations, known: Fit, space: Space, x: Array, train: Sequence[int], coarse: Sequence[float]
) -> Array:
    """The change of the residual per scaled value: known ones as they are, new ones simulated. Shape (m, p)."""
    have = {(known.changes[i].suspect, name): k for k, (i, name) in enumerate(known.names)}
    places = [have.get((space.changes[i].suspect, name)) for i, name in space.names]
    new = [k for k, place in enumerate(places) if place is None]
    fresh = slope(simulations, space, x, train, coarse, new)
    columns = []
    for k, place in enumerate(places):
        if place is None:
            columns.append(fresh[:, new.index(k)])
        else:
            columns.append(known.slope[:, place] * space.scale[k] / known.size[place])
    return np.column_stack(columns)
