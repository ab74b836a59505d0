"""Whether the intervals of findings tell them from what a model without them has."""

from __future__ import annotations

import numpy as np
from scipy.stats import chi2

from realitygap.diagnose.candidates.suspects import neutral
from realitygap.diagnose.data.changes import Suspect
from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.search.evidence import Scored
from realitygap.robot.drive import Array

TOLD = 0.95
"""A finding whose interval at this level holds what a model without it has is doubtful, whatever its evidence: what
stretches of the recordings say scatters more than the likelihood tells."""


def untold(problem: Problem, scored: Scored) -> set[Suspect]:
    """The findings whose intervals, all values of one together, hold what a model without them has."""
    away, covariance = away_of(problem, scored), scored.covariance
    wider = scored.deviation / scored.fit.size / np.sqrt(np.diag(covariance))
    covariance = covariance * np.outer(wider, wider)
    return {
        suspect
        for suspect, at in places(problem, scored).items()
        if float(away[at] @ np.linalg.solve(covariance[np.ix_(at, at)], away[at])) <= float(chi2.ppf(TOLD, len(at)))
    }


def places(problem: Problem, scored: Scored) -> dict[Suspect, list[int]]:
    """The numbers of the values that a finding does nothing without, of those that can be absent."""
    fit, out = scored.fit, dict[Suspect, list[int]]()
    for number, change in enumerate(fit.changes):
        kind, zero = change.suspect.kind, neutral(problem.plant, change.suspect)
        own = [k for k, (i, _) in enumerate(fit.names) if i == number]
        at = [k for k in own if not kind.parameter(fit.names[k][1]).shape]
        if own and all(np.isfinite(zero[fit.names[k][1]]) for k in at):
            out[change.suspect] = at
    return out


def away_of(problem: Problem, scored: Scored) -> Array:
    """How far every value is from where it does nothing, in sizes. Shape (p,)."""
    fit = scored.fit
    zero = [neutral(problem.plant, fit.changes[i].suspect)[name] for i, name in fit.names]
    return np.asarray((fit.value - np.array(zero)) / fit.size)
