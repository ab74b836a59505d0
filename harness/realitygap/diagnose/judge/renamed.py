"""A model with another name for what was found: whether it comes near, and what was found with it."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

from realitygap.diagnose.data.changes import Change, Suspect
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.judge.held_out import as_wide
from realitygap.diagnose.likelihood.floors import measure
from realitygap.diagnose.search.evidence import Scored
from realitygap.diagnose.search.found import Found
from realitygap.diagnose.search.rivals import FAR, Rival


def retold(simulations: Simulations, found: Found, before: Found) -> Found:
    """What was found with its values fitted as if laws were exact, which tells them best, where its names are others
    than before: models that are compared are where their evidence is best. Of two links, beside dry friction that had
    taken the place of friction by side, a spring of 14 N·m/rad was left at 19.5, and is 13.9.
    """
    best = None if found.best is before.best else found.criterion.fit(found.best.fit.changes, found.best.fit)
    return found if best is None else with_best(simulations, found, best)


def with_best(simulations: Simulations, found: Found, best: Scored) -> Found:
    """What was found with another best model, its floors, and intervals that are as wide as those of the one before."""
    cautious = as_wide(found.criterion.cautious(best.fit), found.cautious)
    return replace(found, best=best, cautious=cautious, floors=measure(simulations, best.fit.changes))


def renamed(
    simulations: Simulations,
    found: Found,
    before: Collection[Suspect],
    plain: Scored,
    alone: Scored | None,
    rivals: Sequence[Rival],
) -> Found:
    """What was found with another name in the place of findings, which is the last change of its model; `alone` is the
    model without it.
    """
    name = plain.fit.changes[-1].suspect
    left = {s: v for s, v in found.without.items() if s not in before}
    gains = {s: v for s, v in found.gains.items() if s not in before}
    if alone is not None:
        left[name], gains[name] = alone, plain.evidence - alone.evidence
    others = {s: of for s, of in found.rivals.items() if s not in before}
    least = max((found.least.get(s, found.limit) for s in before), default=found.limit)
    return replace(
        with_best(simulations, found, plain),
        gains=gains,
        without=left,
        rivals={**others, name: list(rivals)},
        least={**found.least, name: least},
    )


def near(found: Found, changes: Sequence[Change]) -> Scored | None:
    """A model that is fitted quickly; None where it is far behind what was found."""
    quick = found.criterion.fit(changes, found.best.fit, "quick")
    return quick if quick is not None and close(found, quick) else None


def close(found: Found, quick: Scored) -> bool:
    """Whether a quick fit comes near enough to what was found to be fitted in full."""
    return found.best.evidence - quick.evidence <= FAR * found.limit


def rest_of(changes: Sequence[Change], gone: Collection[Suspect]) -> list[Change]:
    """The changes of all other suspects."""
    return [c for c in changes if c.suspect not in gone]
