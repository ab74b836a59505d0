"""What else could stand in the place of a finding: exchanged, fitted, and compared by evidence.

The same comparison says three things: whether another name is better, how much better the name is than the next best
explanation, and which names the recordings cannot tell apart (a model confidence set, Hansen, Lunde & Nason 2011, with
the test of Vuong 1989: the difference in evidence beside its standard error over stretches of the recordings).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from realitygap.diagnose.data.changes import Change, Suspect
from realitygap.diagnose.likelihood.whitening import Channel
from realitygap.diagnose.search.evidence import Scored, stretches
from realitygap.robot.drive import Array

LEVEL = 1.64
"""Standard errors of a difference that keep a rival in the confidence set: 95 %, one-sided."""
ODDS = 3.0
"""Difference in evidence (odds of 20 to 1) below which a rival stays in it anyway."""


@dataclass(frozen=True)
class Rival:
    """A model with another suspect in the place of a finding; `behind` is how much evidence it has less, `error` the
    standard error of that.
    """

    suspect: Suspect
    scored: Scored
    behind: float
    error: float

    @property
    def open(self) -> bool:
        """Whether the recordings cannot tell it from the finding."""
        return self.behind <= max(ODDS, LEVEL * self.error)


def compare(channels: Sequence[Channel], best: Scored, other: Scored, suspect: Suspect) -> Rival:
    """How far another model is behind the best one."""
    a, b = (_stretches(channels, s) for s in (best, other))
    apart = a - b
    error = float(np.sqrt(len(apart)) * np.std(apart)) if len(apart) > 1 else 0.0
    return Rival(suspect, other, best.evidence - other.evidence, error)


def _stretches(channels: Sequence[Channel], scored: Scored) -> Array:
    """Minus half the squared innovations of every stretch of every motion, all channels of it together."""
    number = stretches(channels)
    white = scored.metric(scored.fit.residual)
    return np.asarray(-0.5 * np.bincount(number, white[: len(number)] ** 2))


def without(changes: Sequence[Change], number: int) -> tuple[Change, ...]:
    """The changes without one of them."""
    return (*changes[:number], *changes[number + 1 :])
