"""Plainer names after all, where a richer one says no more of the same law than laws are off by.

The search asks that too, as long as it has time: a round that is late tells which names cannot be told apart, and looks
for no others. Dry friction of 0.11 N·m was left told by side, as 0.096 and 0.126 N·m, and the plain one was likelier.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence

from realitygap.diagnose.candidates.starts import guess
from realitygap.diagnose.candidates.suspects import fitted, many_joints
from realitygap.diagnose.data.changes import Change, Suspect, stands_beside
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.judge.held_out import besides, predicted
from realitygap.diagnose.judge.joined import joined
from realitygap.diagnose.judge.renamed import close, renamed, rest_of, retold
from realitygap.diagnose.search.alike import same
from realitygap.diagnose.search.apart import compare, told_apart
from realitygap.diagnose.search.evidence import EQUAL, Scored
from realitygap.diagnose.search.found import Found
from realitygap.diagnose.search.grow import with_shape
from realitygap.diagnose.search.rivals import ODDS, Rival
from realitygap.diagnose.search.simpler import narrower
from realitygap.diagnose.search.special_case import no_more

SAME = 4
"""So many that do most of what a finding does, with fewer values, are asked: one of them is told, with three others
that it cannot be told from. On an arm's first joint a mass, an inertia and a rotor may do the same."""


def told_plainly(
    simulations: Simulations, found: Found, everyone: Sequence[Suspect], keep: Collection[Suspect]
) -> Found:
    """What was found in as few and as plain names as say as much: `joined`, then `plainer`."""
    said = joined(simulations, found, everyone, keep)
    return retold(simulations, plainer(simulations, said, everyone, keep), said)


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
            found = said_plainly(simulations, found, change.suspect, plain) if plain else found
    there = {c.suspect for c in before.fit.changes}
    others = {c.suspect for c in found.best.fit.changes}.intersection(there).difference(keep)
    return besides(found, others, "quick") if found.best is not before else found


def _within(found: Found, suspect: Suspect, plain: Scored) -> bool:
    """Whether a model with a special case of a finding, its last, says as much as that with it (`no_more`)."""
    without = found.without.get(suspect)
    special = narrower(plain.fit.changes[-1].suspect, suspect)
    return special and no_more(found.criterion, found.best, plain, suspect, without, found.limit)


def _plain(simulations: Simulations, found: Found, change: Change, everyone: Sequence[Suspect]) -> list[Scored]:
    """The models with a plainer name that says as much in the place of a finding, the plain name last; the likeliest
    first.
    """
    rest = rest_of(found.best.fit.changes, {change.suspect})
    said = list[Scored]()
    for suspect, begun in _plainer_names(found, change, everyone).items():
        if not stands_beside(suspect, [c.suspect for c in rest]) or _in_parts(change.suspect, suspect, rest):
            continue
        ways = [[*beside, plain] for beside in (rest, *_reshaped(simulations, change, rest)) for plain in begun]
        quick = (found.criterion.fit(way, found.best.fit, "quick") for way in ways)
        near = next((q for q in quick if q and (close(found, q) or _within(found, change.suspect, q))), None)
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
    the richer one, where training runs do at all: which model it is they alone choose. What was found is compared where
    its evidence is best, which its values, fitted as if laws were exact, need not be: a gantry's friction by side, 20
    and 33 N, was 21 behind dry friction, which widened the held-out gap from 13 to 30 floors, and is ahead of it there.

    Of a slide friction by side, 3 and 20 N, beside a spring that rests elsewhere, which together are dry friction of
    11.5 N, was 2.7 behind that, and held-out runs were 17 ± 8 for it.
    """
    best = found.best
    if plain.evidence >= best.evidence:
        best = max(best, found.criterion.refined(best) or best, key=lambda scored: scored.evidence)
        if plain.evidence >= best.evidence:
            return True
    within = _within(found, suspect, plain) if suspect.table is None else told_apart(best, plain) < ODDS
    likely = best.evidence - plain.evidence < ODDS or within
    return likely and not predicted(simulations, found.floors, best.fit.changes, plain.fit.changes).better


def said_plainly(simulations: Simulations, found: Found, before: Suspect, plain: Sequence[Scored]) -> Found:
    """What was found with the likeliest of other names in the place of a finding, from which the others and that one
    may not be told. Their models come the likeliest first, each with the name last.
    """
    best, known = plain[0], found.rivals.get(before, [])
    others = [(other.fit.changes[-1].suspect, other) for other in plain[1:]]
    instead = [Rival(s, m, *compare(found.criterion.channels, best, m)) for s, m in [*others, (before, found.best)]]
    instead.sort(key=lambda rival: rival.behind)
    named = {best.fit.changes[-1].suspect, *(r.suspect for r in instead)}
    rest = [r for r in known if not named.intersection(r.suspects)]
    return renamed(simulations, found, [before], best, found.without.get(before), [*instead, *rest])
