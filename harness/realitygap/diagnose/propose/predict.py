"""Predictions: what every explanation says that motions will show, whitened as a diagnosis would whiten it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from realitygap.diagnose.data.changes import Suspect
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.fit.fit import Fit, slope
from realitygap.diagnose.fit.motions import Motions
from realitygap.diagnose.fit.space import Space
from realitygap.diagnose.likelihood.floors import Floors
from realitygap.diagnose.likelihood.whitening import Channel, Whitening, channels
from realitygap.diagnose.propose.odds import Belief
from realitygap.diagnose.propose.predicted_discrepancy import PredictedDiscrepancy
from realitygap.diagnose.search.evidence import Scored
from realitygap.robot.drive import Array


@dataclass(frozen=True)
class Predictions:
    """What explanations predict of motions, as columns: first one for every explanation, then one for every value.

    Attributes:
        cases: the numbers of the motions.
        channels: of what is stacked.
        still: what the named model says, less what was measured. Shape (m,).
        plain: the columns as they are simulated, of explanations less that of the named model. Shape (m, c).
        whitenings: of each motion.
        grams: of each motion, the inner products of the whitened columns. Shape (c, c) each.
        beliefs: of every explanation.
    """

    cases: tuple[int, ...]
    channels: tuple[Channel, ...]
    still: Array
    plain: Array
    whitenings: tuple[Whitening, ...]
    grams: tuple[Array, ...]
    beliefs: tuple[Belief, ...]

    def expected(self, number: int, part: slice) -> Array:
        """What an explanation expects of a part of what is stacked, less what was measured. Shape (k,)."""
        return np.asarray(self.still[part] + self.plain[part] @ self.beliefs[number].mean)

    def uncertain(self, number: int, part: slice) -> Array:
        """The standard deviation of that by what is not known of the explanation's values. Shape (k,)."""
        belief = self.beliefs[number]
        ways = self.plain[part] @ belief.ways
        return np.asarray(np.sqrt(np.sum((ways @ belief.covariance) * ways, axis=1)))

    def of(self, case: int) -> tuple[Array, Array]:
        """What the named model says of one motion (m,), and the columns (m, c)."""
        rows = _rows(self.channels, case)
        return self.still[rows], self.plain[rows]

    def white(self, case: int, columns: Array) -> Array:
        """Columns of one motion, whitened. Shape (m, k) -> (r, k)."""
        return _white(self.whitenings[self.cases.index(case)], columns)


def _rows(channels: Sequence[Channel], case: int) -> NDArray[np.bool_]:
    """Which stacked samples are those of one motion. Shape (m,)."""
    return np.concatenate([np.full(len(c.time), c.case == case) for c in channels])


def _white(whitening: Whitening, columns: Array) -> Array:
    return whitening(np.ascontiguousarray(columns), np.ones(len(columns)))[0]


def predict(
    simulations: Simulations,
    explanations: Sequence[Scored],
    cases: Sequence[int],
    floors: Floors,
    discrepancy: PredictedDiscrepancy | None = None,
) -> Predictions | None:
    """The predictions of some motions; None where one of them cannot be simulated.

    Args:
        simulations: of the problem with the motions.
        explanations: fitted to its training cases, the named model first.
        cases: the motions.
        floors: of all cases.
        discrepancy: what laws may be off by; None as if laws were exact.
    """
    found = tuple(channels(simulations.problem, floors, cases))
    ahead = _simulated(simulations, explanations, cases, floors, alone=discrepancy is not None)
    if ahead is None:
        return None
    means, slopes = ahead
    laws = np.zeros((len(means), 0)) if discrepancy is None else discrepancy.ahead
    still = means[:, 0]
    plain = np.nan_to_num(np.column_stack([means - still[:, None], *slopes, laws]))
    first = explanations[0].metric.whitening
    grams, whitenings = [], []
    for case in cases:
        own = tuple(c for c in found if c.case == case)
        whitenings.append(first.elsewhere(own))
        white = _white(whitenings[-1], plain[_rows(found, case)])
        grams.append(white.T @ white)
    beliefs = _beliefs(simulations, explanations, [s.shape[1] for s in slopes], discrepancy)
    return Predictions(tuple(cases), found, still, plain, tuple(whitenings), tuple(grams), beliefs)


def _simulated(
    simulations: Simulations, explanations: Sequence[Scored], cases: Sequence[int], floors: Floors, *, alone: bool
) -> tuple[Array, list[Array]] | None:
    """What each explanation says (m, e), and how that changes with its values, each (m, v): for itself alone, or, where
    the named model has a value too, as that one changes with it. Rivals differ from it in a finding or two and fit the
    same recordings: for a first look at many pieces that is close, in half the time or less.
    """
    motions = Motions(simulations, cases, floors.coarse)
    answers = motions.residuals([e.fit.changes for e in explanations])
    means = [a for a in answers if a is not None]
    if len(means) < len(answers):
        return None
    known: dict[tuple[Suspect, str], Array] = {}
    slopes = []
    for e in explanations:
        space = Space(simulations.problem, e.fit.changes)
        values = [(space.changes[i].suspect, name) for i, name in space.names]
        own = [k for k, value in enumerate(values) if alone or value not in known]
        told = np.zeros((len(means[0]), len(values)))
        if own:
            told[:, own] = slope(motions, space, space.first, values=own) / space.scale[own]
        for k in set(range(len(values))) - set(own):
            told[:, k] = known[values[k]]
        if not known:
            known = {value: told[:, k] for k, value in enumerate(values)}
        slopes.append(told * e.fit.size)
    return np.column_stack(means), slopes


def _beliefs(
    simulations: Simulations,
    explanations: Sequence[Scored],
    sizes: Sequence[int],
    discrepancy: PredictedDiscrepancy | None,
) -> tuple[Belief, ...]:
    """Of every explanation, what the training cases leave of its values and of how far laws are off."""
    number = len(explanations)
    laws = 0 if discrepancy is None else discrepancy.ahead.shape[1]
    width = number + sum(sizes) + laws
    ends = np.cumsum([number, *sizes])
    out = []
    for k, e in enumerate(explanations):
        fit, shares = e.fit, np.zeros(0)
        old = fit.slope.reshape(len(fit.residual), -1)
        if discrepancy is not None:
            named = discrepancy.named
            shares = named.shares(fit) * np.array([e.discrepancy_scale.get(law, 1.0) for law in named.laws])
            old = np.column_stack([old, discrepancy.before * shares])
        white, _ = e.metric.whitening(np.nan_to_num(np.column_stack([fit.residual, old])), e.metric.weight)
        lean, stiff = _prior(simulations, fit, laws)
        precision = white[:, 1:].T @ white[:, 1:] + np.diag(stiff**2)
        pull = white[:, 1:].T @ white[:, 0] + stiff * lean
        ways = np.zeros((width, sizes[k] + laws))
        ways[ends[k] : ends[k + 1], : sizes[k]] = np.eye(sizes[k])
        ways[ends[-1] :, sizes[k] :] = np.diag(shares)
        mean = np.zeros(width)
        mean[k] = 1.0
        start = np.asarray(-np.linalg.solve(precision, pull))
        out.append(Belief(mean + ways @ start, ways, precision, start))
    return tuple(out)


def _prior(simulations: Simulations, fit: Fit, laws: int) -> tuple[Array, Array]:
    """How far values are from where priors expect them, and how fast that grows with each. Shapes (v,)."""
    space = Space(simulations.problem, fit.changes)
    stiff = space.prior_slope(space.first) * (fit.size / space.scale if len(fit.size) else 1.0)
    return np.concatenate([fit.prior, np.zeros(laws)]), np.concatenate([stiff, np.ones(laws)])
