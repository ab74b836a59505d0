"""Moves that leave out: findings that a model does not need, the least first."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2

from realitygap.diagnose.candidates.suspects import neutral
from realitygap.diagnose.data.changes import Suspect
from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.fit.space import SLAB
from realitygap.diagnose.search.evidence import Scored
from realitygap.diagnose.search.round import Round

DOUBTFUL = 2.0
"""A finding is tried without where a straight line says that it gains less than this many times what a name needs; what
its interval does not tell is left out where a fit says the same."""
TOLD = 0.95
"""A finding whose interval at this level holds what a model without it has is doubtful, whatever its evidence: what
stretches of the recordings say scatters more than the likelihood tells."""


@dataclass(frozen=True)
class Loss:
    """What a model loses without a finding, by straight lines: evidence, and whether its interval tells it at all."""

    evidence: float
    told: bool


def pruned(round_: Round, found: Scored, keep: Sequence[Suspect], told: bool = False) -> Scored:
    """A model without the findings that gain less than a name needs, each tried in a quick fit; `keep` stays.

    With `told`, also without those that their intervals do not tell, and without which little more is lost: of a model
    that is whole. Before, stretches scatter by what is still missing.
    """
    needed = set(keep)
    now = found
    while True:
        losses = straight_losses(round_.simulations.problem, now)
        doubtful = {s: loss for s, loss in losses.items() if s not in needed}
        doubtful = {s: d for s, d in doubtful.items() if (told and not d.told) or d.evidence < DOUBTFUL * round_.limit}
        if not doubtful:
            return now
        least = min(doubtful, key=lambda s: doubtful[s].evidence)
        rest = [c for c in now.fit.changes if c.suspect != least]
        without = round_.adjusted(rest, now.fit)
        enough = DOUBTFUL if told and not doubtful[least].told else 1.0
        if without is not None and now.evidence - without.evidence < enough * round_.limit:
            now = without
        else:
            needed.add(least)


def straight_losses(problem: Problem, scored: Scored) -> dict[Suspect, Loss]:
    """What a model loses without each finding, by the straight lines at its fit (Wald 1943).

    What is absent only at an infinite value, as a compliance, is left out.
    """
    fit, out = scored.fit, dict[Suspect, Loss]()
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
        far = float(away @ information @ away)
        out[change.suspect] = Loss(0.5 * far - max(occam, 0.0), far > float(chi2.ppf(TOLD, len(at))))
    return out
