"""Foreseen odds: what a diagnosis would say if a motion were recorded as one explanation predicts it.

Recordings of the motion are what the explanation that is taken for true predicts as it stands, with noise as it lasts
in the present ones. Both explanations are then fitted in simulation to the old recordings and the foreseen one
together, and compared by the evidence that a diagnosis goes by. What laws may be off by, what no law explains, what is
an outlier and how many effective samples there are is thus told by what the wrong one leaves, as it will be: a
likelihood in which all of that was known beforehand promises odds that no diagnosis gives.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from realitygap.diagnose.data.case import JOINT_SIGNALS
from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.fit.fit import Fit
from realitygap.diagnose.fit.motions import residual
from realitygap.diagnose.likelihood.floors import Floors
from realitygap.diagnose.likelihood.whitening import Channel, channels, spans
from realitygap.diagnose.propose.design import Answer
from realitygap.diagnose.propose.explanations import Open, Question
from realitygap.diagnose.propose.predict import Predictions
from realitygap.diagnose.propose.predicted_discrepancy import PredictedDiscrepancy
from realitygap.diagnose.propose.refit import refitted
from realitygap.diagnose.search.criterion import Criterion
from realitygap.diagnose.search.evidence import STRETCH, Scored
from realitygap.diagnose.search.rivals import ODDS
from realitygap.robot.drive import Array

SAME = ODDS
"""Half the squared distance, in the metric of a diagnosis, below which two explanations that are both fitted to the
same recordings predict the same: by what is seen alone the odds for one of them stay below 20 : 1."""
DRAWS = 3
"""Recordings with other noise that are foreseen for each explanation; the median of their odds is told."""


@dataclass(frozen=True)
class Foreseen:
    """One motion, recorded behind the training motions.

    Attributes:
        simulations: of the problem with the motions.
        open: the explanations.
        predictions: of the motions.
        floors: of all cases.
        discrepancy: what laws may be off by.
        case: the number of the motion.
    """

    simulations: Simulations
    open: Open
    predictions: Predictions
    floors: Floors
    discrepancy: PredictedDiscrepancy
    case: int

    def answers(self, questions: Sequence[Question]) -> list[Answer | None]:
        """What the motion does to questions: the median of the logarithm of the odds for each side, if it is true; None
        where a side cannot be fitted to it.
        """
        sides = [(q.one, q.other) for q in questions]
        sides += [(b, a) for a, b in sides]
        told: dict[tuple[int, int], tuple[float, bool]] = {}
        for true in dict.fromkeys(a for a, _ in sides):
            others = [b for a, b in sides if a == true]
            told |= {(true, b): side for b, side in self._odds(true, others).items()}
        pairs = [(told.get((q.one, q.other)), told.get((q.other, q.one))) for q in questions]
        return [None if a is None or b is None else Answer(a[0], b[0], (a[1], b[1])) for a, b in pairs]

    def _odds(self, true: int, others: Sequence[int]) -> dict[int, tuple[float, bool]]:
        """The odds of an explanation, if it is true, over others that can be fitted to it, and whether those do the
        same then.
        """
        random = np.random.default_rng([self.case, true])
        drawn = [self._noise(self.open.explanations[true], random) for _ in range(DRAWS)]
        still, columns = self.predictions.of(self.case)
        first = self._criterion(still + columns[:, true] + drawn[0])
        tried = {k: _fitted(first, self.open.explanations[k].fit) for k in (true, *others)}
        fits = {k: scored for k, scored in tried.items() if scored is not None}
        if true not in fits:
            return {}
        more = [d - drawn[0] for d in drawn]
        asked: dict[int, list[int]] = {}
        for other in fits:
            if other != true:
                asked.setdefault(_simpler(fits, true, other), []).append(other)
        told = dict[int, tuple[float, bool]]()
        for at, beside in asked.items():
            here = self._criterion_at(first, fits[at], at)
            one, *two = (self._evidences(here, fits[k].fit, more) for k in (true, *beside))
            alike = [self._alike(here, fits[true].fit, fits[k].fit) for k in beside]
            odds = [float(np.median(one - e)) for e in two]
            told |= dict(zip(beside, zip(odds, alike, strict=True), strict=True))
        return told

    def _alike(self, here: Criterion, true: Fit, other: Fit) -> bool:
        """Whether an explanation with as many findings does what the true one does, both fitted to the same."""
        if len(true.changes) != len(other.changes):
            return False
        apart = here.score(true).metric(other.residual - true.residual)
        return 0.5 * float(apart @ apart) < SAME

    def _criterion_at(self, first: Criterion, fitted: Scored, at: int) -> Criterion:
        """The criterion where laws may be off, and effective samples count, as at an explanation that was fitted."""
        here = copy(first)
        here.discrepancy = replace(
            self.discrepancy.at(at, self.case), effective_fraction=first.discrepancy.effective_fraction
        )
        here.set_effective_fraction(fitted.fit.residual)
        here.set_effective_fraction(here.score(fitted.fit).left)
        return here

    def _evidences(self, here: Criterion, fit: Fit, more: Sequence[Array]) -> Array:
        """The evidence of an explanation near where it was fitted, for recordings with other noise. Shape (draws,)."""
        return np.array([_evidence(here, self._beside(fit, m)) for m in more])

    def _criterion(self, shown: Array) -> Criterion:
        """The criterion, where the motion showed this. Shape (m,)."""
        problem = _recorded(self.simulations.problem, self.case, shown)
        simulations = copy(self.simulations)
        simulations.problem = problem
        changes = self.open.explanations[0].fit.changes
        criterion = Criterion(simulations, changes, self.floors)
        left = residual(simulations, changes, criterion.train)
        assert left is not None
        criterion.set_effective_fraction(left)
        return criterion

    def _noise(self, true: Scored, random: np.random.Generator) -> Array:
        """Stretches of what an explanation leaves of the recordings, in floors, one behind the other, of all channels
        at once (moving blocks, Künsch 1989). Shape (m,).
        """
        problem = self.simulations.problem
        train = problem.of("train")
        left: dict[tuple[int, str, int], Array] = {}
        for channel, span in spans(channels(problem, self.floors, train)):
            floor = np.hypot(channel.noise, channel.slow)
            left[channel.case, *channel.key] = np.nan_to_num(true.left[span] / floor)
        new: Sequence[Channel] = channels(problem, self.floors, [self.case])
        picks = _stretches(problem, train, len(new[0].time), random)
        parts = []
        for channel in new:
            drawn = np.concatenate([left[c, *channel.key][rows] for c, rows in picks])[: len(channel.time)]
            parts.append(drawn * np.hypot(channel.noise, channel.slow))
        return np.concatenate(parts)

    def _beside(self, fit: Fit, more: Array) -> Fit:
        """A fit where the motion shows something more. Shape (m,)."""
        changed = fit.residual.copy()
        changed[len(changed) - len(more) :] -= more
        return replace(fit, residual=changed)


def _fitted(criterion: Criterion, fit: Fit) -> Scored | None:
    """An explanation, fitted in simulation."""
    if fit.names:
        return criterion.fit(fit.changes, care="compared")
    still = residual(criterion.simulations, fit.changes, criterion.train)
    return None if still is None else criterion.score(replace(fit, residual=still, slope=np.zeros((len(still), 0))))


def _simpler(fits: Mapping[int, Scored], one: int, other: int) -> int:
    """Where two explanations are compared: at the one with fewer findings, where a diagnosis asks whether anything more
    is to be named; of two with as many, at the better one.
    """
    return min((one, other), key=lambda k: (len(fits[k].fit.changes), -fits[k].evidence))


def _evidence(criterion: Criterion, near: Fit) -> float:
    """The evidence of an explanation near where it was fitted, refitted along straight lines."""
    return criterion.score(refitted(criterion.problem, near, criterion.plain(near).metric)).evidence


def _recorded(problem: Problem, case: int, shown: Array) -> Problem:
    """The problem where a motion was recorded and showed this, stacked as its channels are. Shape (m,)."""
    cases = list(problem.cases)
    own = cases[case]
    rows, first = len(own.measured.time), 0
    signals = dict[str, Array]()
    for signal in problem.signals(case):
        value = np.zeros((rows, len(problem.judged)))
        number = int(problem.judged.sum())
        value[:, problem.judged] = shown[first : first + rows * number].reshape(number, rows).T
        signals[signal], first = value, first + rows * number
    joints = {s: signals.get(s) for s in JOINT_SIGNALS}
    measured = replace(own.measured, position=joints["position"], velocity=joints["velocity"], effort=joints["effort"])
    cases[case] = replace(own, measured=measured, use="train")
    return replace(problem, cases=tuple(cases))


def _stretches(
    problem: Problem, train: Sequence[int], number: int, random: np.random.Generator
) -> list[tuple[int, NDArray[np.int64]]]:
    """Samples of training motions, a stretch of one behind that of another, so many at least."""
    out, count = list[tuple[int, NDArray[np.int64]]](), 0
    while count < number:
        case = int(random.choice(train))
        time = problem.cases[case].measured.time
        length = min(max(int(STRETCH * (len(time) - 1) / (time[-1] - time[0])), 1), len(time))
        first = int(random.integers(len(time) - length + 1))
        out.append((case, np.arange(first, first + length)))
        count += length
    return out
