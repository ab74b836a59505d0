"""Moves that leave out: findings that a model does not need, the least first."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from realitygap.diagnose.candidates.suspects import neutral
from realitygap.diagnose.data.changes import Suspect
from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.fit.space import SLAB
from realitygap.diagnose.search.evidence import Scored
from realitygap.diagnose.search.round import Round

DOUBTFUL = 2.0
"""A finding is tried without where a straight line says that it gains less than this many times what a name needs."""


def pruned(round_: Round, found: Scored, keep: Sequence[Suspect]) -> Scored:
    """A model without the findings that gain less than a name needs, each tried in a quick fit; `keep` stays."""
    needed = set(keep)
    now = found
    while True:
        losses = straight_losses(round_.simulations.problem, now)
        doubtful = sorted((loss, s) for s, loss in losses.items() if s not in needed)
        doubtful = [(loss, s) for loss, s in doubtful if loss < DOUBTFUL * round_.limit]
        if not doubtful:
            return now
        _, least = doubtful[0]
        rest = [c for c in now.fit.changes if c.suspect != least]
        without = round_.adjusted(rest, now.fit)
        if without is not None and now.evidence - without.evidence < round_.limit:
            now = without
        else:
            needed.add(least)


def straight_losses(problem: Problem, scored: Scored) -> dict[Suspect, float]:
    """The evidence that a model loses without each finding, by the straight lines at its fit (Wald 1943).

    What is absent only at an infinite value, as a compliance, is left out.
    """
    fit, out = scored.fit, dict[Suspect, float]()
    for number, change in enumerate(fit.changes):
        zero = neutral(problem.plant, change.suspect)
        own = [k for k, (i, _) in enumerate(fit.names) if i == number]
        names = [fit.names[k][1] for k in own]
        shape = [change.suspect.kind.parameter(n).shape for n in names]
        if not own or any(not np.isfinite(zero[n]) for n, s in zip(names, shape, strict=True) if not s):
            continue
        at = [k for k, s in zip(own, shape, strict=True) if not s]
        away = np.array([(change.parameters[fit.names[k][1]] - zero[fit.names[k][1]]) / fit.size[k] for k in at])
        information = np.linalg.inv(scored.covariance[np.ix_(at, at)])
        occam = 0.5 * float(np.linalg.slogdet(SLAB**2 * information)[1])
        out[change.suspect] = 0.5 * float(away @ information @ away) - max(occam, 0.0)
    return out
