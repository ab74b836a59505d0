"""Refits along straight lines, for what differs little from what was fitted in simulation."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.optimize import lsq_linear

from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.fit.fit import Fit
from realitygap.diagnose.fit.space import Space
from realitygap.diagnose.likelihood.metric import Metric

TINY = 1e-12
"""A box has an inside."""


def refitted(problem: Problem, fit: Fit, metric: Metric) -> Fit:
    """A fit with its values where straight lines lead in a metric, within their bounds."""
    if not fit.names:
        return fit
    space = Space(problem, fit.changes)
    unit = fit.size / space.scale
    stiff = space.prior_slope(space.first) * unit
    white = np.column_stack([metric(fit.slope), metric(fit.residual)])
    white = np.vstack([white, np.column_stack([np.diag(stiff), fit.prior])])
    _, triangle = np.linalg.qr(white)
    low, high = ((b - space.first) / unit for b in space.bounds())
    step = lsq_linear(triangle[:-1, :-1], -triangle[:-1, -1], bounds=(low - TINY, high + TINY)).x
    there = space.at(space.first + np.clip(step, low, high) * unit)
    prior = Space(problem, there)
    return replace(
        fit, changes=there, residual=fit.residual + fit.slope @ step, prior=prior.prior(prior.first), here=False
    )
