"""Refits along straight lines, for what differs little from what was fitted in simulation."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.fit.fit import Fit, nearest
from realitygap.diagnose.fit.space import Space
from realitygap.diagnose.likelihood.metric import Metric


def refitted(problem: Problem, fit: Fit, metric: Metric) -> Fit:
    """A fit with its values where straight lines lead in a metric, within their bounds."""
    if not fit.names:
        return fit
    space = Space(problem, fit.changes)
    unit = fit.size / space.scale
    stiff = space.prior_slope(space.first) * unit
    white = np.column_stack([metric(fit.slope), metric(fit.residual)])
    white = np.vstack([white, np.column_stack([np.diag(stiff), fit.prior])])
    step = nearest(white, *((b - space.first) / unit for b in space.bounds()))
    there = space.at(space.first + step * unit)
    prior = Space(problem, there)
    return replace(
        fit, changes=there, residual=fit.residual + fit.slope @ step, prior=prior.prior(prior.first), here=False
    )
