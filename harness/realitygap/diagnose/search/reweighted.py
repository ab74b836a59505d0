"""A fit in passes, each in the metric of what the one before left (iteratively reweighted least squares).

What is an outlier, and what no law explains, is told by the model itself.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Literal

import numpy as np

from realitygap.diagnose.data.changes import Change
from realitygap.diagnose.fit.fit import CHEAP, Fit, fit, resized, stretched
from realitygap.diagnose.fit.motions import Motions
from realitygap.diagnose.search.evidence import Scored

SETTLE, SETTLE_MANY = 4, 12
"""How often a model is fitted at most, each time in the metric of what the one before leaves; the same with many values
(`fit.CHEAP`), which a pass takes fewer steps with."""
FURTHER = (2.0, 4.0, 8.0, 16.0)
"""How many times as far as a pass went is tried, as long as evidence grows. The metric learns from what a pass leaves,
so that each goes only part of the way, as steps of expectation and maximisation do (Varadhan & Roland 2008): along a
line from a fitted humanoid the best for its metric gained 36 to 66, and the best place 82."""
SIZES = (0.5, 0.7, 1.4, 2.0)
"""What stands last in a model that settled is tried at these multiples of what it is there: late in a swing, where its
effect bends, more of it may do far better, with something worse between. Of three pendulums that swing freely, with dry
friction of 0.15 N·m, 7 of 44 fits from 0.012 to 0.4 N·m ended elsewhere, 40 to 90 behind; with these, 2 of 44."""
SETTLED, SETTLED_MANY = 1.0, 3.0
"""The gain in evidence below which a model has settled; with many values, where derivatives are those of where it is:
what is rough moves them by more than that (`fit.axes`), and no judgement hangs on less (`rivals.ODDS`)."""
BENT = 3
"""Up to so many new values are followed by their own slopes in a quick fit, anew in each pass: they bend most."""

Plain = Callable[[Fit], Scored]
"""The evidence of a fit, and its metric, as if laws were exact."""


def reweighted(
    motions: Motions, plain: Plain, start: Scored, near: Fit | None, care: Literal["quick", "compared"]
) -> Scored | None:
    """The best of the passes of a fit, which end where it has settled; None where it cannot be simulated.

    With many values that begins anew once, with derivatives of where it is; with few of them, by other sizes of the
    last change.

    Args:
        motions: to fit to.
        plain: scores each pass.
        start: the changes with first guesses.
        near: a fitted model near by, whose derivatives may be taken at first.
        care: of every pass; a quick fit ends where it settles first.
    """
    quick, best = care == "quick", None
    many = not quick and sum(len(c.free) for c in start.fit.changes) >= CHEAP
    anew, other_sizes = False, not many and not quick
    for _ in range(SETTLE_MANY if many else SETTLE):
        done = fit(motions, start.fit.changes, start.metric, near, care, anew)
        if done is None:
            break
        if near is None or not quick or len(done.names) - len(near.names) > BENT:
            near = done
        began, start = start.fit.changes, plain(done)
        if not quick:
            start = _further(motions, plain, began, start)
        gain = start.evidence - best.evidence if best is not None else np.inf
        best = start if gain > 0.0 or best is None else best
        if gain >= (SETTLED_MANY if many else SETTLED):
            anew = False
        elif many and not anew:
            start, near, anew = best, best.fit, True
        elif other_sizes and (other := _resized(motions, plain, best)) is not None:
            start, near, other_sizes = other, best.fit, False
        else:
            break
    return best


def _further(motions: Motions, plain: Plain, began: Sequence[Change], found: Scored) -> Scored:
    """A pass from some values, extrapolated beyond what it found as far as evidence grows."""
    best = found
    for times in FURTHER if found.fit.names else ():
        there = stretched(motions, began, found.fit, times)
        further = None if there is None else plain(there)
        if further is None or further.evidence <= best.evidence:
            break
        best = further
    return best


def _resized(motions: Motions, plain: Plain, found: Scored) -> Scored | None:
    """A model with another size of its last change, where that has more evidence; None where none has."""
    tried = (resized(motions, found.fit, times) for times in SIZES)
    best = max((plain(f) for f in tried if f is not None), key=lambda f: f.evidence, default=found)
    return best if best.evidence > found.evidence else None
