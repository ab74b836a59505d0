"""Moves that leave out (backward elimination): findings that a model does not need, the least first."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from functools import partial

import numpy as np
from scipy.special import chdtri

from realitygap.diagnose.candidates.suspects import neutral
from realitygap.diagnose.data.changes import Suspect
from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.fit.space import SLAB
from realitygap.diagnose.search.evidence import Scored
from realitygap.diagnose.search.round import DOUBTFUL, Round
from realitygap.robot.drive import Array

TOLD = 0.95
"""A finding whose interval at this level holds what a model without it has is doubtful, whatever its evidence: what
stretches of the recordings say scatters more than the likelihood tells."""
HINTED = 0.8
"""The same level for a finding that is not doubtful by its evidence: what laws are off by anyway, its interval holds as
well. Beside nearly right laws of seeds nobody had looked into, three true frictions that were 12 to 22 % off lay 1.6 to
1.9 standard deviations from what their models had, and two false findings 0.6 and 1.0."""


def pruned(round_: Round, found: Scored, keep: Sequence[Suspect], told: bool = False) -> Scored:
    """A model without the findings that gain less than a name needs, judged by quick fits; `keep` stays.

    First at once what the linearised model says that can go together: a plain fit of a robot has a dozen too many.
    Where that loses what a name needs, each half of it is tried, and so on: of 45 that the linearised model said were
    worth nothing on a humanoid, one was worth 49. Then what is doubtful, one by one.

    With `told`, also without those that their intervals do not tell, and without which little more is lost: of a model
    that is whole. Before, stretches scatter by what is still missing.
    """
    problem, limit, workers = round_.simulations.problem, round_.limit, round_.simulations.workers
    needed, now = set(keep), found
    leaving, known = [superfluous(problem, now, needed, limit)], dict[tuple[Suspect, ...], Scored | None]()
    while leaving and leaving[-1]:
        ahead = [tuple(some) for some in leaving[-workers:] if tuple(some) not in known]
        known |= zip(ahead, round_.simulations.side_by_side(partial(_left_out, round_, now), ahead), strict=True)
        some = leaving.pop()
        without, half = known[tuple(some)], len(some) // 2
        if without is not None and now.evidence - without.evidence < limit:
            now, known = without, {}  # what others lose beside it is not known yet
        elif half:
            leaving += [some[half:], some[:half]]
        elif not told:
            needed.update(some)
    while True:
        losses = wald_losses(problem, now)
        vague = untold(problem, round_.criterion.as_told(now.fit)) if told else set[Suspect]()
        losses = dict.fromkeys(vague, 0.0) | losses
        doubtful = {s: d for s, d in losses.items() if s not in needed and (s in vague or d < DOUBTFUL * limit)}
        if not doubtful:
            return now
        least = sorted(doubtful, key=lambda s: doubtful[s])[:workers]
        tried = round_.simulations.side_by_side(partial(_left_out, round_, now), [[s] for s in least])
        for suspect, without in zip(least, tried, strict=True):
            enough = DOUBTFUL if suspect in vague else 1.0
            if without is not None and now.evidence - without.evidence < enough * limit:
                now = without
                break
            needed.add(suspect)


def _left_out(round_: Round, now: Scored, some: Collection[Suspect]) -> Scored | None:
    """A model without some of its findings, fitted quickly."""
    return round_.adjusted([c for c in now.fit.changes if c.suspect not in some], now.fit)


def superfluous(problem: Problem, scored: Scored, keep: Collection[Suspect], limit: float) -> list[Suspect]:
    """What could go together by the linearised model at a fit, the least first: each loses less than the limit beside
    those before it.
    """
    places = {s: at for s, at in _places(problem, scored).items() if s not in keep}
    away, out, lost, gone = _away(problem, scored), list[Suspect](), 0.0, list[int]()
    while places:
        losses = {s: _loss(scored, away, [*gone, *at]) for s, at in places.items()}
        least = min(losses, key=lambda s: losses[s])
        if losses[least] - lost >= limit:
            break
        lost, gone = losses[least], [*gone, *places.pop(least)]
        out.append(least)
    return out


def wald_losses(problem: Problem, scored: Scored) -> dict[Suspect, float]:
    """The evidence that a model loses without each finding, by the linearised model at its fit (Wald's test, 1943).

    What is absent only at an infinite value, as a compliance, is left out.
    """
    away = _away(problem, scored)
    return {suspect: _loss(scored, away, at) for suspect, at in _places(problem, scored).items()}


def untold(problem: Problem, scored: Scored, sure: Collection[Suspect] = ()) -> set[Suspect]:
    """The findings whose intervals, all values of one together, hold what a model without them has; of those that are
    `sure` by their evidence narrower ones.

    Of what is absent only at an infinite value it is the interval of its inverse: of a profile whose acceleration was
    2800 rad/s² with a standard error of 6900, as if there were none.
    """
    away, covariance = _away(problem, scored), scored.covariance
    wider = scored.deviation / scored.fit.size / np.sqrt(np.diag(covariance))
    covariance = covariance * np.outer(wider, wider)
    out = set[Suspect]()
    for suspect, at in _places(problem, scored, endless=True).items():
        apart = float(away[at] @ np.linalg.solve(covariance[np.ix_(at, at)], away[at]))
        if apart <= float(chdtri(len(at), 1.0 - (HINTED if suspect in sure else TOLD))):
            out.add(suspect)
    return out


def _loss(scored: Scored, away: Array, at: Sequence[int]) -> float:
    """The evidence that is lost without some values: half of Wald's statistic, less the Occam factor. As stretches
    scatter by what is still missing they say less, and of a humanoid's fit that without half of it nothing is lost,
    where 250 are.
    """
    information = np.linalg.inv(scored.laplace_covariance[np.ix_(at, at)])
    occam = 0.5 * float(np.linalg.slogdet(SLAB**2 * information)[1])
    return 0.5 * float(away[at] @ information @ away[at]) - max(occam, 0.0)


def _places(problem: Problem, scored: Scored, endless: bool = False) -> dict[Suspect, list[int]]:
    """The numbers of the values that a finding does nothing without, of those that can be absent; also where that is
    only if they are infinite, if `endless`.
    """
    fit, out = scored.fit, dict[Suspect, list[int]]()
    for number, change in enumerate(fit.changes):
        kind, zero = change.suspect.kind, neutral(problem.plant, change.suspect)
        own = [k for k, (i, _) in enumerate(fit.names) if i == number]
        at = [k for k in own if not kind.parameter(fit.names[k][1]).shape]
        if own and (endless or all(np.isfinite(zero[fit.names[k][1]]) for k in at)):
            out[change.suspect] = at
    return out


def _away(problem: Problem, scored: Scored) -> Array:
    """How far every value is from where it does nothing, in sizes; the inverse of a value from zero, in sizes of the
    inverse, where it does nothing if it is infinite. Shape (p,).
    """
    fit = scored.fit
    zero = np.array([neutral(problem.plant, fit.changes[i].suspect)[name] for i, name in fit.names])
    away = fit.value - np.where(np.isfinite(zero), zero, 0.0)
    return np.asarray(np.where(np.isfinite(zero), away, -away) / fit.size)
