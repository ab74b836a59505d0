"""Refits in simulation: how much of a distance is left when the other explanation follows as far as it really can.

Straight lines tell where its values would go; it is simulated there, and goes on from there, because friction that
sticks and play answer as no straight line tells.
"""

from __future__ import annotations

import numpy as np

from realitygap.diagnose.data.changes import Change
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.fit.responses import residuals
from realitygap.diagnose.likelihood.floors import Floors
from realitygap.diagnose.propose.design import Answer
from realitygap.diagnose.propose.explanations import Open, Question
from realitygap.diagnose.propose.odds import expected
from realitygap.diagnose.propose.predict import Predictions
from realitygap.diagnose.search.evidence import Scored
from realitygap.robot.drive import Array

STEPS = 3
"""Steps of a refit, each along the straight lines of the first."""


def simulated(
    simulations: Simulations, open_: Open, question: Question, predictions: Predictions, case: int, floors: Floors
) -> Answer:
    """What a motion does to a question, with the other explanation refitted in simulation."""
    gram = predictions.grams[predictions.cases.index(case)]

    def odds(true: int, other: int) -> float:
        distance = _distance(simulations, open_.explanations[other], predictions, case, floors, true, other)
        return expected(gram, predictions.beliefs[true], predictions.beliefs[other], distance)

    return Answer(question.now + odds(question.one, question.other), -question.now + odds(question.other, question.one))


def _distance(
    simulations: Simulations,
    scored: Scored,
    predictions: Predictions,
    case: int,
    floors: Floors,
    true: int,
    other: int,
) -> float | None:
    """The least squared distance that steps of the other explanation's values leave; None where it has none to move."""
    belief, count = predictions.beliefs[other], len(scored.fit.names)
    if not count:
        return None
    still, plain = predictions.of(case)
    truth = plain @ predictions.beliefs[true].mean
    ways = predictions.white(case, plain @ belief.ways)
    step = np.linalg.inv(belief.precision + ways.T @ ways)
    laws = plain @ belief.ways[:, count:]
    at, best = np.zeros(len(belief.precision)), np.inf
    for _ in range(STEPS + 1):
        (answer,) = residuals(simulations, [_at(scored, (belief.start + at)[:count])], [case], floors.coarse)
        if answer is None:
            break
        predicted = np.nan_to_num(answer - still) + laws @ (belief.start + at)[count:]
        apart = predictions.white(case, (truth - predicted)[:, None])[:, 0]
        cost = float(apart @ apart + at @ belief.precision @ at)
        if cost >= best:
            break
        best, reached = cost, at
        at = reached + step @ (ways.T @ apart - belief.precision @ reached)
    return best if np.isfinite(best) else None


def _at(scored: Scored, values: Array) -> tuple[Change, ...]:
    """The explanation with its values moved by so many sizes, within their bounds."""
    fit = scored.fit
    told: list[dict[str, float]] = [{} for _ in fit.changes]
    for (i, name), v, size, far in zip(fit.names, fit.value, fit.size, values, strict=True):
        p = fit.changes[i].suspect.kind.parameter(name)
        told[i][name] = float(np.clip(v + size * far, p.low, p.high))
    return tuple(c.at(v) for c, v in zip(fit.changes, told, strict=True))
