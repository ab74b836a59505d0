"""Plainer names after all, where a richer one says no more of the same law than laws are off by, and one name for two.

The search asks that too, as long as it has time: a round that is late tells which names cannot be told apart, and looks
for no others. Dry friction of 0.11 N·m was left told by side, as 0.096 and 0.126 N·m, and the plain one was likelier;
and a spring at zero beside a constant effort for one that rests elsewhere.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace
from itertools import combinations

from realitygap.diagnose.candidates.starts import guess
from realitygap.diagnose.candidates.suspects import many_joints
from realitygap.diagnose.data.changes import Change, Suspect, clash
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.judge.held_out import as_wide, predicted
from realitygap.diagnose.likelihood.floors import measure
from realitygap.diagnose.search.apart import compare
from realitygap.diagnose.search.evidence import Scored
from realitygap.diagnose.search.grow import with_shape
from realitygap.diagnose.search.rivals import FAR, ODDS, Rival
from realitygap.diagnose.search.search import Found
from realitygap.diagnose.search.simpler import narrower


def told_plainly(
    simulations: Simulations, found: Found, everyone: Sequence[Suspect], keep: Collection[Suspect]
) -> Found:
    """What was found in as few and as plain names as say as much: `joined`, then `plainer`. With many joints, of which
    each fit costs many simulations, only the search asks.
    """
    if many_joints(simulations.problem):
        return found
    return plainer(simulations, joined(simulations, found, everyone, keep), everyone, keep)


def plainer(simulations: Simulations, found: Found, everyone: Sequence[Suspect], keep: Collection[Suspect]) -> Found:
    """What was found with the plainest name of the same law for each finding that says as much, all values fitted anew:
    likelier than the richer one, or as likely, or apart from it by no more than such laws are off by. `keep` stays, and
    what held-out runs speak for. The richer name is told as one that cannot be told from it.
    """
    for change in found.best.fit.changes:
        if change.suspect not in {*keep, *found.adjusted}:
            plain = _plain(simulations, found, change, everyone)
            found = found if plain is None else _said_plainly(simulations, found, change.suspect, plain)
    return found


def joined(simulations: Simulations, found: Found, everyone: Sequence[Suspect], keep: Collection[Suspect]) -> Found:
    """What was found with one law in the place of two that it says together, where that loses no more than a finding
    has to gain and held-out runs do not speak for both: a finding with its shape freed, of it and another one at its
    joints; or what two findings at one place are special cases of. `keep` stays.

    A load of 60 g at the end of a forearm was a link that is 17 % heavier, with 1.4 times its inertia.
    """
    ways = [*_shaped(simulations, found), *_both_of(simulations, found, everyone)]
    asked = [(one, gone) for one, gone in ways if not (gone - {one.suspect}).intersection(keep)]
    said = [_in_place_of_both(simulations, found, one, gone) for one, gone in asked]
    best = max((f for f in said if f is not None), key=lambda f: f.best.evidence, default=None)
    return found if best is None else joined(simulations, best, everyone, keep)


def _shaped(simulations: Simulations, found: Found) -> Iterator[tuple[Change, set[Suspect]]]:
    """Every finding with its shape freed, with another one at its joints in whose place it may stand, too."""
    for change in found.best.fit.changes:
        shaped = with_shape(simulations.problem.plant, change, 1.0)
        for other in found.best.fit.changes if change.free and shaped is not change else ():
            if other.free and set(other.suspect.joints) <= set(change.suspect.joints) and other is not change:
                yield shaped, {change.suspect, other.suspect}


def _both_of(
    simulations: Simulations, found: Found, everyone: Sequence[Suspect]
) -> Iterator[tuple[Change, set[Suspect]]]:
    """What two findings are special cases of, of those that may stand in their place, with these two."""
    free = [c.suspect for c in found.best.fit.changes if c.free]
    for a, b in combinations(free, 2):
        others = [c.suspect for c in found.best.fit.changes if c.suspect not in (a, b)]
        for suspect in everyone:
            both = narrower(a, suspect) and narrower(b, suspect)
            if both and not any(suspect == o or clash(suspect, o) for o in others):
                yield guess(simulations.problem, suspect), {a, b}


def _in_place_of_both(simulations: Simulations, found: Found, one: Change, gone: Collection[Suspect]) -> Found | None:
    """What was found with one change in the place of two findings; None where that says less."""
    yardstick, best = found.yardstick, found.best
    rest = [c for c in best.fit.changes if c.suspect not in gone]
    quick = yardstick.fit([*rest, one], best.fit, "quick")
    if quick is None or best.evidence - quick.evidence > FAR * found.limit:
        return None
    full = yardstick.fit(quick.fit.changes, quick.fit)  # as if laws were exact, as what it stands for was fitted
    if full is None or best.evidence - full.evidence >= found.limit:
        return None
    if not predicted(simulations, found.floors, best.fit.changes, full.fit.changes).worse:
        return None
    named = any(s not in found.adjusted for s in gone)  # what takes the place of a name is one
    adjusted = tuple(s for s in found.adjusted if s not in gone)
    left = replace(found, adjusted=adjusted if named else (*adjusted, one.suspect))
    alone = yardstick.fit(rest, best.fit, "quick")
    return _renamed(simulations, left, gone, full, alone, [])


def _plain(simulations: Simulations, found: Found, change: Change, everyone: Sequence[Suspect]) -> Scored | None:
    """The likeliest model with a plainer name that says as much in the place of a finding, the plain name last."""
    yardstick, best = found.yardstick, found.best
    rest = [c for c in best.fit.changes if c.suspect != change.suspect]
    said = list[Scored]()
    for suspect in everyone:
        if not narrower(suspect, change.suspect) or any(clash(suspect, c.suspect) for c in rest):
            continue
        quick = yardstick.fit([*rest, guess(yardstick.problem, suspect)], best.fit, "quick")
        if quick is None or best.evidence - quick.evidence > FAR * found.limit:
            continue
        full = yardstick.refined(quick)
        if full is not None and _says_as_much(simulations, found, change.suspect, full):
            said.append(full)
    return max(said, key=lambda scored: scored.evidence, default=None)


def _says_as_much(simulations: Simulations, found: Found, suspect: Suspect, plain: Scored) -> bool:
    """Whether a model with a plainer name says as much as the one that was found, and held-out runs do not speak for
    the richer one.
    """
    best, yardstick = found.best, found.yardstick
    likely = best.evidence - plain.evidence < ODDS or yardstick.alike(best.fit, plain.fit, suspect)
    return likely and predicted(simulations, found.floors, best.fit.changes, plain.fit.changes).worse


def _said_plainly(simulations: Simulations, found: Found, before: Suspect, plain: Scored) -> Found:
    """What was found with a plainer name in the place of a finding, from which the richer one may not be told."""
    name, known = plain.fit.changes[-1].suspect, found.rivals.get(before, [])
    richer = Rival(before, found.best, *compare(found.yardstick.channels, plain, found.best))
    others = [r for r in known if name not in r.suspects]
    return _renamed(simulations, found, [before], plain, found.without.get(before), [richer, *others])


def _renamed(
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
        found,
        best=plain,
        cautious=as_wide(found.yardstick.cautious(plain.fit), found.cautious),
        floors=measure(simulations, plain.fit.changes),
        gains=gains,
        without=left,
        rivals={**others, name: list(rivals)},
        least={**found.least, name: least},
    )
