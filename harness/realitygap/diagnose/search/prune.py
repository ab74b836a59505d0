"""Moves that leave out: findings that a model does not need, the least first."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from functools import partial

import numpy as np

from realitygap.diagnose.data.changes import Suspect
from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.fit.space import SLAB
from realitygap.diagnose.search.evidence import Scored
from realitygap.diagnose.search.round import DOUBTFUL, Round
from realitygap.diagnose.search.told import away_of, places, untold
from realitygap.robot.drive import Array


def pruned(round_: Round, found: Scored, keep: Sequence[Suspect], told: bool = False) -> Scored:
    """A model without the findings that gain less than a name needs, judged by quick fits; `keep` stays.

    First at once what straight lines say that can go together: a plain fit of a robot has a dozen too many. Where that
    loses what a name needs, each half of it is tried, and so on: of 45 that straight lines said were worth nothing on a
    humanoid, one was worth 49. Then what is doubtful, one by one.

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
        losses = straight_losses(problem, now)
        vague = untold(problem, round_.yardstick.as_told(now.fit)) if told else set[Suspect]()
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
    """What could go together by the straight lines at a fit, the least first: each loses less than the limit beside
    those before it.
    """
    left = {s: at for s, at in places(problem, scored).items() if s not in keep}
    away, out, lost, gone = away_of(problem, scored), list[Suspect](), 0.0, list[int]()
    while left:
        losses = {s: _loss(scored, away, [*gone, *at]) for s, at in left.items()}
        least = min(losses, key=lambda s: losses[s])
        if losses[least] - lost >= limit:
            break
        lost, gone = losses[least], [*gone, *left.pop(least)]
        out.append(least)
    return out


def straight_losses(problem: Problem, scored: Scored) -> dict[Suspect, float]:
    """The evidence that a model loses without each finding, by the straight lines at its fit (Wald 1943).

    What is absent only at an infinite value, as a compliance, is left out.
    """
    away = away_of(problem, scored)
    return {suspect: _loss(scored, away, at) for suspect, at in places(problem, scored).items()}


def _loss(scored: Scored, away: Array, at: Sequence[int]) -> float:
    """The evidence that is lost without some values. As stretches scatter by what is still missing they say less, and
    of a humanoid's fit that without half of it nothing is lost, where 250 are.
    """
    information = np.linalg.inv(scored.likely[np.ix_(at, at)])
    occam = 0.5 * float(np.linalg.slogdet(SLAB**2 * information)[1])
    return 0.5 * float(away[at] @ information @ away[at]) - max(occam, 0.0)
