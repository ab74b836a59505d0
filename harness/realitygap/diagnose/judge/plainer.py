"""Plainer names after all, where a richer one says no more of the same law than laws are off by, and one name for two.

The search asks that too, as long as it has time: a round that is late tells which names cannot be told apart, and looks
for no others. Dry friction of 0.11 N·m was left told by side, as 0.096 and 0.126 N·m, and the plain one was likelier;
and a spring at zero beside a constant effort for one that rests elsewhere.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace
from itertools import combinations, permutations

import numpy as np

from realitygap.diagnose.candidates.starts import guess
from realitygap.diagnose.candidates.suspects import fitted, many_joints
from realitygap.diagnose.data.changes import Change, Suspect, stands_beside
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.judge.held_out import as_wide, besides, predicted
from realitygap.diagnose.likelihood.floors import measure
from realitygap.diagnose.search.alike import in_place, same
from realitygap.diagnose.search.apart import compare, told_apart
from realitygap.diagnose.search.evidence import EQUAL, Scored
from realitygap.diagnose.search.found import Apart, Found, Said
from realitygap.diagnose.search.grow import with_shape
from realitygap.diagnose.search.rivals import FAR, ODDS, Rival
from realitygap.diagnose.search.round import MUCH
from realitygap.diagnose.search.simpler import narrower
from realitygap.diagnose.search.special_case import as_law, no_more

SAME = 4
"""So many that do most of what a finding does, with fewer values, are asked: one of them is told, with three others
that it cannot be told from. On an arm's first joint a mass, an inertia and a rotor may do the same."""


def told_plainly(
    simulations: Simulations, found: Found, everyone: Sequence[Suspect], keep: Collection[Suspect]
) -> Found:
    """What was found in as few and as plain names as say as much: `joined`, then `plainer`."""
    said = joined(simulations, found, everyone, keep)
    return retold(simulations, plainer(simulations, said, everyone, keep), said)


def retold(simulations: Simulations, found: Found, before: Found) -> Found:
    """What was found with its values fitted as if laws were exact, which tells them best, where its names are others
    than before: models that are compared are where their evidence is best. Of two links, beside dry friction that had
    taken the place of friction by side, a spring of 14 N·m/rad was left at 19.5, and is 13.9.
    """
    best = None if found.best is before.best else found.criterion.fit(found.best.fit.changes, found.best.fit)
    return found if best is None else _with_best(simulations, found, best)


def _with_best(simulations: Simulations, found: Found, best: Scored) -> Found:
    """What was found with another best model, its floors, and intervals that are as wide as those of the one before."""
    cautious = as_wide(found.criterion.cautious(best.fit), found.cautious)
    return replace(found, best=best, cautious=cautious, floors=measure(simulations, best.fit.changes))


def plainer(simulations: Simulations, found: Found, everyone: Sequence[Suspect], keep: Collection[Suspect]) -> Found:
    """What was found with the plainest name for each finding that says as much, all values fitted anew: likelier than
    the richer one, or as likely, or of the same law and apart from it by no more than such laws are off by. `keep`
    stays, and what held-out runs speak for. The richer name is told as one that cannot be told from it. With many
    joints, of which each fit costs many simulations, only the search asks.

    The models without each of the others have the plain name as well: of a slide, friction by side, 10.7 and 10.9 N,
    came back for the plain one with the model in which another finding had been left out before.
    """
    before = found.best
    for change in () if many_joints(simulations.problem) else found.best.fit.changes:
        if change.suspect not in {*keep, *found.adjusted}:
            plain = _plain(simulations, found, change, everyone)
            found = _said_plainly(simulations, found, change.suspect, plain) if plain else found
    there = {c.suspect for c in before.fit.changes}
    others = {c.suspect for c in found.best.fit.changes}.intersection(there).difference(keep)
    return besides(found, others, "quick") if found.best is not before else found


def joined(simulations: Simulations, found: Found, everyone: Sequence[Suspect], keep: Collection[Suspect]) -> Found:
    """What was found with one law in the place of two that it says together, where that loses no more than a finding
    has to gain and held-out runs do not speak for both: a finding in a richer shape, of it and another one at its
    joints (`_richer`); or what two findings at one place are special cases of, also where that is apart from them by no
    more than such laws are off by. `keep` stays.

    A load of 60 g at the end of a forearm was a link that is 17 % heavier, with 1.4 times its inertia. A hand's load of
    2.1 kg was a mass and another centre of it, 25 ahead, and apart from the load by an eighth of what loads are off by.
    """
    there = frozenset(c.suspect for c in found.best.fit.changes)
    apart = set(found.apart.among(there))
    richer = () if many_joints(simulations.problem) else _richer(simulations, found, everyone, keep, apart)
    ways = [*richer, *_both_of(found, everyone, keep)]
    said = [_in_place_of_both(simulations, found, way, gone) for way, gone in ways]
    best = max((f for f in said if f is not None), key=lambda f: f.best.evidence, default=None)
    if best is None:
        return replace(found, apart=Apart(frozenset(apart), there)) if apart else found
    others = {c.suspect for c in best.best.fit.changes}.difference(keep)
    return joined(simulations, besides(best, others, "quick"), everyone, keep)


Way = tuple[list[Change], set[Suspect]]
"""A model with one change, its last, in the place of two findings of another; and these."""


def _richer(
    simulations: Simulations,
    found: Found,
    everyone: Sequence[Suspect],
    keep: Collection[Suspect],
    apart: set[Said],
) -> Iterator[Way]:
    """Every finding with its shape freed, or as the law of which it is a special case, with another one at its joints
    in whose place that may stand, too; without what a quick fit tells is far behind, which goes to those `apart`.
    """
    changes = found.best.fit.changes
    for change, other in permutations([c for c in changes if c.free], 2):
        gone = {change.suspect, other.suspect}
        within = set(other.suspect.joints) <= set(change.suspect.joints) and other.suspect not in keep
        rest = _without(changes, gone)
        richer = _in_richer_shape(simulations, found, change, other, everyone) if within else ()
        for one in richer:
            if change.suspect in keep and one.suspect != change.suspect:
                continue
            said = one.suspect, frozenset(gone)
            quick = None if said in apart else _near(found, [*rest, one])
            if quick is not None:
                yield list(quick.fit.changes), gone
            else:
                apart.add(said)


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
    beside = _without(found.best.fit.changes, {change.suspect, other.suspect})
    for law in everyone:
        if narrower(change.suspect, law) and stands_beside(law, [c.suspect for c in beside]):
            richer = as_law(simulations.problem, change, law)
            if richer is not None:
                yield richer


def _both_of(found: Found, everyone: Sequence[Suspect], keep: Collection[Suspect]) -> Iterator[Way]:
    """What two findings are special cases of, of those that may stand in their place, with these two."""
    changes = found.best.fit.changes
    for a, b in combinations([c.suspect for c in changes if c.free and c.suspect not in keep], 2):
        rest = _without(changes, {a, b})
        for suspect in everyone:
            both = narrower(a, suspect) and narrower(b, suspect)
            if both and stands_beside(suspect, [c.suspect for c in rest]):
                yield [*rest, _like(found, suspect, {a, b})], {a, b}


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
    """What was found with one change, the last of a way, in the place of two findings; None where that says less."""
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
    alone = criterion.fit(_without(best.fit.changes, gone), best.fit, "quick")
    return _renamed(simulations, left, gone, full, alone, [])


def _near(found: Found, changes: Sequence[Change]) -> Scored | None:
    """A model that is fitted quickly; None where it is far behind what was found."""
    quick = found.criterion.fit(changes, found.best.fit, "quick")
    return quick if quick is not None and _close(found, quick) else None


def _close(found: Found, quick: Scored) -> bool:
    """Whether a quick fit comes near enough to what was found to be fitted in full."""
    return found.best.evidence - quick.evidence <= FAR * found.limit


def _within(found: Found, suspect: Suspect, plain: Scored) -> bool:
    """Whether a model with a special case of a finding, its last, says as much as that with it (`no_more`)."""
    without = found.without.get(suspect)
    special = narrower(plain.fit.changes[-1].suspect, suspect)
    return special and no_more(found.criterion, found.best, plain, suspect, without, found.limit)


def _without(changes: Sequence[Change], gone: Collection[Suspect]) -> list[Change]:
    """The changes of all other suspects."""
    return [c for c in changes if c.suspect not in gone]


def _plain(simulations: Simulations, found: Found, change: Change, everyone: Sequence[Suspect]) -> list[Scored]:
    """The models with a plainer name that says as much in the place of a finding, the plain name last; the likeliest
    first.
    """
    rest = _without(found.best.fit.changes, {change.suspect})
    said = list[Scored]()
    for suspect, begun in _plainer_names(found, change, everyone).items():
        if not stands_beside(suspect, [c.suspect for c in rest]) or _in_parts(change.suspect, suspect, rest):
            continue
        ways = [[*beside, plain] for beside in (rest, *_reshaped(simulations, change, rest)) for plain in begun]
        quick = (found.criterion.fit(way, found.best.fit, "quick") for way in ways)
        near = next((q for q in quick if q and (_close(found, q) or _within(found, change.suspect, q))), None)
        full = None if near is None else found.criterion.refined(near)
        if full is not None and _says_as_much(simulations, found, change.suspect, full):
            said.append(full)
    return sorted(said, key=lambda scored: -scored.evidence)


def _in_parts(law: Suspect, plain: Suspect, rest: Sequence[Change]) -> bool:
    """Whether a plain name and another change of a model are parts of a law, and so no plainer than it: a load, and a
    mass beside another centre of it.
    """
    return narrower(plain, law) and any(narrower(c.suspect, law) for c in rest)


def _reshaped(simulations: Simulations, change: Change, rest: Sequence[Change]) -> Iterator[list[Change]]:
    """The other findings with the shape of one of them freed that sits at the joints of a finding: it may say the rest
    of what that does.

    A slide's spring, 116 N/m from zero, beside friction by side, 33 and 21 N, is one that rests elsewhere beside dry
    friction of 27 N: the same traces with as many values.
    """
    for i, other in enumerate(rest):
        shaped = with_shape(simulations.problem.plant, other, 1.0)
        if shaped is not other and other.free and other.suspect.joints == change.suspect.joints:
            yield [*rest[:i], shaped, *rest[i + 1 :]]


def _plainer_names(found: Found, change: Change, everyone: Sequence[Suspect]) -> dict[Suspect, list[Change]]:
    """Special cases of a finding, and what of its law does most of the same with fewer values, as straight lines beside
    it tell; each as it is begun: a first guess, and as much of it as the finding does, which straight lines overdo
    where that grows with two of its values.

    Of an effort without a law, those that were seen to make the same traces in its place, or to explain as much.

    A load on the axis of an arm's second joint turns about the first, and does nothing else there: of an arm whose
    first rotor was heavier it was told with four values, the search having had no time to ask for its name.
    """
    criterion, suspect = found.criterion, change.suspect
    if suspect.table is not None:
        known = [r for r in found.rivals.get(suspect, ()) if r.beside is None and r.suspect.table is None]
        laws = [r for r in known if r.same or r.behind < EQUAL]
        return {r.suspect: [r.scored.fit.changes[-1]] for r in laws}
    special = [s for s in everyone if narrower(s, suspect)]
    fewer = [s for s in everyone if s.kind.law == suspect.kind.law != "" and len(fitted(s.kind)) < len(change.free)]
    blocks = criterion.responses(found.best.fit, [s for s in fewer if s not in special])
    does = same(criterion, found.best.fit, [change], blocks, SAME)
    first = {s: [guess(criterion.problem, s)] for s in [*special, *does]}
    return first | {s: [*first[s], like] for s, like in does.items()}


def _says_as_much(simulations: Simulations, found: Found, suspect: Suspect, plain: Scored) -> bool:
    """Whether a model with a plainer name says as much as the one that was found, and held-out runs do not speak for
    the richer one, where training runs do at all: which model it is they alone choose.

    Of a slide friction by side, 3 and 20 N, beside a spring that rests elsewhere, which together are dry friction of
    11.5 N, was 2.7 behind that, and held-out runs were 17 ± 8 for it.
    """
    best = found.best
    if plain.evidence >= best.evidence:
        return True
    within = _within(found, suspect, plain) if suspect.table is None else told_apart(best, plain) < ODDS
    likely = best.evidence - plain.evidence < ODDS or within
    return likely and not predicted(simulations, found.floors, best.fit.changes, plain.fit.changes).better


def _said_plainly(simulations: Simulations, found: Found, before: Suspect, plain: Sequence[Scored]) -> Found:
    """What was found with the likeliest plainer name in the place of a finding, from which the others and the richer
    one may not be told.
    """
    best, known = plain[0], found.rivals.get(before, [])
    others = [(other.fit.changes[-1].suspect, other) for other in plain[1:]]
    instead = [Rival(s, m, *compare(found.criterion.channels, best, m)) for s, m in [*others, (before, found.best)]]
    instead.sort(key=lambda rival: rival.behind)
    named = {best.fit.changes[-1].suspect, *(r.suspect for r in instead)}
    rest = [r for r in known if not named.intersection(r.suspects)]
    return _renamed(simulations, found, [before], best, found.without.get(before), [*instead, *rest])


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
        _with_best(simulations, found, plain),
        gains=gains,
        without=left,
        rivals={**others, name: list(rivals)},
        least={**found.least, name: least},
    )
