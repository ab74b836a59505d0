"""The findings one after the other: the model of every step, with values that were fitted for it."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import accumulate

from realitygap.diagnose.data.changes import Change, Suspect, as_read
from realitygap.diagnose.fit.fit import Fit, fit, residual_near
from realitygap.diagnose.search.criterion import Criterion
from realitygap.diagnose.search.found import Found

MANY = 4
"""More findings than this are told by effect: a step is an effect at all its places, since every step is simulated in
every engine, a sentence tells how many places, and a table has the values."""


def in_steps(ordered: Sequence[Suspect]) -> list[list[Suspect]]:
    """Findings by steps, in their order: one alone, or, of many, those of an effect."""
    out: dict[Suspect | str, list[Suspect]] = {}
    for suspect in ordered:
        out.setdefault(suspect.effect if len(ordered) > MANY else suspect, []).append(suspect)
    return list(out.values())


def steps_of(found: Found, ordered: Sequence[Suspect]) -> list[list[Suspect]]:
    """What was found by steps, in its order: the last one is what its laws are off by, where that was told."""
    beside = [s for s in ordered if s in found.adjusted]
    return [*in_steps([s for s in ordered if s not in found.adjusted]), *([beside] if beside else [])]


def steps(found: Found, ordered: Sequence[Suspect]) -> list[tuple[Change, ...]]:
    """The models without any finding and after each step, each with its own values: those of the step after it, moved
    to where the training runs are likelier without what that one adds.

    A finding's value beside all others is not the one that it has alone: a gain that stands for what friction is off by
    made the gap of held-out runs larger (66 to 93 floors) in the step that added it to friction as it is beside that
    gain.
    """
    known = found.best.fit
    *prefixes, every = accumulate(steps_of(found, ordered), initial=list[Suspect]())
    out = [_in_order(known.changes, every)]
    for prefix in reversed(prefixes):
        fewer = [c for c in out[0] if c.suspect in prefix]
        moved = _moved(found.criterion, fewer, known) if any(c.free for c in fewer) else None
        known = known if moved is None else moved
        out.insert(0, _in_order(fewer if moved is None else moved.changes, prefix))
    return out


def _moved(criterion: Criterion, changes: Sequence[Change], near: Fit) -> Fit | None:
    """Fewer changes than those of a fit, in a few steps from there; None where they cannot be simulated."""
    changes = as_read(changes, near.changes, criterion.problem.plant)
    left = residual_near(criterion.motions, near, changes)
    if left is None:
        return None
    metric = criterion.plain(Fit(tuple(changes), left)).metric
    return fit(criterion.motions, changes, metric, near, "quick")


def _in_order(changes: Sequence[Change], ordered: Sequence[Suspect]) -> tuple[Change, ...]:
    return tuple(sorted(changes, key=lambda c: ordered.index(c.suspect)))
