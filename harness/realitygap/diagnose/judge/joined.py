"""One law in the place of two findings that it says together, and one value for all joints in the place of one at each.

The search asks that too, as long as it has time. A spring at zero beside a constant effort was left for one that rests
elsewhere.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace
from itertools import combinations, permutations

import numpy as np

from realitygap.diagnose.candidates.starts import guess
from realitygap.diagnose.candidates.suspects import many_joints
from realitygap.diagnose.data.changes import Change, Suspect, stands_beside
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.judge.held_out import besides, predicted
from realitygap.diagnose.judge.renamed import near, renamed, rest_of
from realitygap.diagnose.search.alike import in_place
from realitygap.diagnose.search.found import Apart, Found, Said
from realitygap.diagnose.search.grow import alike, one_for_all, with_shape
from realitygap.diagnose.search.round import MUCH
from realitygap.diagnose.search.simpler import narrower
from realitygap.diagnose.search.special_case import as_law


def joined(simulations: Simulations, found: Found, everyone: Sequence[Suspect], keep: Collection[Suspect]) -> Found:
    """What was found with one law in the place of two that it says together, where that loses no more than a finding
    has to gain and held-out runs do not speak for both: a finding in a richer shape, of it and another one at its
    joints (`_richer`); what two findings at one place are special cases of, also where that is apart from them by no
    more than such laws are off by; or one value for all joints of a group in the place of one at each. `keep` stays.

    A load of 60 g at the end of a forearm was a link that is 17 % heavier, with 1.4 times its inertia. A hand's load of
    2.1 kg was a mass and another centre of it, 25 ahead, and apart from the load by an eighth of what loads are off by.
    """
    there = frozenset(c.suspect for c in found.best.fit.changes)
    apart = set(found.apart.among(there))
    richer = () if many_joints(simulations.problem) else _richer(simulations, found, everyone, keep)
    ways = [*_close(found, [*richer, *_for_all(found, everyone, keep)], apart), *_both_of(found, everyone, keep)]
    said = [_in_place_of_both(simulations, found, way, gone) for way, gone in ways]
    best = max((f for f in said if f is not None), key=lambda f: f.best.evidence, default=None)
    if best is None:
        return replace(found, apart=Apart(frozenset(apart), there)) if apart else found
    others = {c.suspect for c in best.best.fit.changes}.difference(keep)
    return joined(simulations, besides(best, others, "quick"), everyone, keep)


Way = tuple[list[Change], set[Suspect]]
"""A model with one change, its last, in the place of two findings or more; and these."""


def _close(found: Found, ways: Sequence[Way], apart: set[Said]) -> Iterator[Way]:
    """Ways as quick fits leave them, without what these tell is far behind, which goes to those `apart`."""
    for way, gone in ways:
        said = way[-1].suspect, frozenset(gone)
        quick = None if said in apart else near(found, way)
        if quick is not None:
            yield list(quick.fit.changes), gone
        else:
            apart.add(said)


def _richer(
    simulations: Simulations, found: Found, everyone: Sequence[Suspect], keep: Collection[Suspect]
) -> Iterator[Way]:
    """Every finding with its shape freed, or as the law of which it is a special case, with another one at its joints
    in whose place that may stand, too.
    """
    changes = found.best.fit.changes
    for change, other in permutations([c for c in changes if c.free], 2):
        gone = {change.suspect, other.suspect}
        within = set(other.suspect.joints) <= set(change.suspect.joints) and other.suspect not in keep
        rest = rest_of(changes, gone)
        for one in _in_richer_shape(simulations, found, change, other, everyone) if within else ():
            if change.suspect not in keep or one.suspect == change.suspect:
                yield [*rest, one], gone


def _in_richer_shape(
    simulations: Simulations, found: Found, change: Change, other: Change, everyone: Sequence[Suspect]
) -> Iterator[Change]:
    """A finding with its shape freed; and as laws of which it is a special case, if the other one gains little enough
    for what these have besides. A torque-told pendulum's dry friction, 0.16 N·m beside a constant effort of -0.03 N·m,
    is friction by side.
    """
    plant = simulations.problem.plant
    shaped = with_shape(plant, change, 1.0)
    if shaped is not change:
        yield shaped
    if found.gains.get(other.suspect, np.inf) >= MUCH * found.limit:
        return
    beside = rest_of(found.best.fit.changes, {change.suspect, other.suspect})
    for law in everyone:
        if narrower(change.suspect, law) and stands_beside(law, [c.suspect for c in beside]):
            richer = as_law(simulations.problem, change, law)
            if richer is not None:
                yield richer


def _both_of(found: Found, everyone: Sequence[Suspect], keep: Collection[Suspect]) -> Iterator[Way]:
    """What two findings are special cases of, of those that may stand in their place, with these two."""
    changes = found.best.fit.changes
    for a, b in combinations([c.suspect for c in changes if c.free and c.suspect not in keep], 2):
        rest = rest_of(changes, {a, b})
        for suspect in everyone:
            both = narrower(a, suspect) and narrower(b, suspect)
            if both and stands_beside(suspect, [c.suspect for c in rest]):
                yield [*rest, _like(found, suspect, {a, b})], {a, b}


def _for_all(found: Found, everyone: Sequence[Suspect], keep: Collection[Suspect]) -> Iterator[Way]:
    """One value for all joints of a group in the place of one at each."""
    changes = [c for c in found.best.fit.changes if c.suspect not in keep]
    for of in alike(changes):
        gone = {c.suspect for c in of}
        rest = rest_of(found.best.fit.changes, gone)
        together = one_for_all(everyone, of)
        if together is not None and stands_beside(together.suspect, [c.suspect for c in rest]):
            yield [*rest, together], gone


def _like(found: Found, suspect: Suspect, gone: Collection[Suspect]) -> Change:
    """A suspect as it does most like two findings, as straight lines beside them tell; a first guess where none does.

    From a first guess the load of a forearm that had been taken for its mass and its inertia was fitted 450 to 15,000
    behind these, its centre far from where it is.
    """
    criterion, fit = found.criterion, found.best.fit
    blocks = criterion.responses(fit, [suspect])
    lines = in_place(criterion, fit, [c for c in fit.changes if c.suspect in gone], blocks)
    if lines is None:
        return guess(criterion.problem, suspect)
    return lines.gain_of(max(range(len(blocks)), key=lambda i: lines.gain([i]))).change


def _in_place_of_both(
    simulations: Simulations, found: Found, way: Sequence[Change], gone: Collection[Suspect]
) -> Found | None:
    """What was found with one change, the last of a way, in the place of others; None where that says less."""
    criterion, best, one = found.criterion, found.best, way[-1]
    full = criterion.fit(way, best.fit)  # as if laws were exact, as what it stands for was fitted
    if full is None:
        return None
    within = all(narrower(s, one.suspect) for s in gone) and criterion.alike(best.fit, full.fit, one.suspect)
    if not within and best.evidence - full.evidence >= found.limit:
        return None
    if not within and predicted(simulations, found.floors, best.fit.changes, full.fit.changes).better:
        return None
    named = any(s not in found.adjusted for s in gone)  # what takes the place of a name is one
    adjusted = tuple(s for s in found.adjusted if s not in gone)
    left = replace(found, adjusted=adjusted if named else (*adjusted, one.suspect))
    alone = criterion.fit(rest_of(best.fit.changes, gone), best.fit, "quick")
    return renamed(simulations, left, gone, full, alone, [])
