"""What came closest and was not named, with the reason."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from realitygap.diagnose.data.changes import Change
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.judge.gaps import costs, rms
from realitygap.diagnose.search.found import Found
from realitygap.diagnose.search.linear import LinearGain

SHOWN = 3
"""Candidates that were not named and are shown."""


@dataclass(frozen=True)
class Closest:
    """A candidate that was not named: its values, the gap on training runs with it, and why it was refused."""

    change: Change
    before: float
    after: float
    why: str


def closest(simulations: Simulations, found: Found, changes: Sequence[Change]) -> list[Closest]:
    """The candidates with the largest predicted gain that were not named, with the gap on training runs that they
    leave.
    """
    train = simulations.problem.of("train")
    out: list[Closest] = []
    before = rms(costs(simulations, found.floors, changes, train), train)
    for p in found.candidates:
        suspect = p.change.suspect
        known = suspect in found.adjusted or any(suspect == c.change.suspect for c in out)
        if len(out) == SHOWN or p.gain <= 0 or known:
            continue
        after = rms(costs(simulations, found.floors, [*changes, p.change], train), train)
        if float(f"{after:.3g}") < float(f"{before:.3g}"):  # as the page tells them
            out.append(Closest(p.change, before, after, _short_of(found, p)))
    return out


def _short_of(found: Found, candidate: LinearGain) -> str:
    """Why what had the largest predicted gain was not named."""
    why = f"straight lines promise it {candidate.gain:.1f} in evidence, where a name needs {found.limit:.1f}"
    if candidate.gain < found.limit:
        return why
    gain, least = found.short.get(candidate.change.suspect, (-np.inf, found.limit))
    if gain < found.limit:
        return f"{why}, but once it was fitted it gained less than a name needs"
    return (
        f"{why}, and fitted it gains {gain:.1f} of the {least:.1f} by which it would stand out from how stretches "
        "of the recordings scatter, and from what laws leave"
    )
