"""Names after all, or none after all, once what laws are off by is adjusted.

What else is off hides what is missing. Mass and rotor widened the interval of a viscous friction until it held zero;
with another centre of mass and friction by load beside it, it was 1.42 ± 0.04 N·m·s/rad, of 1.48. Beside a rotor's
inertia that was not found, dry friction of two joints, half as large again as in the model, seemed to be what laws are
off by; with the inertia adjusted, all three did 4 to 9 times that. Where nothing but a motor was 3 % weaker than its
effort says, a link's inertia was 2.7 times as large, and beside a mass and a friction 2.0 times, give or take all of
that.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

from realitygap.diagnose.candidates.suspects import neutral
from realitygap.diagnose.data.changes import Suspect
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.judge.gaps import CLEAR, held_out_gap
from realitygap.diagnose.judge.held_out import predicted, sure_of
from realitygap.diagnose.judge.likeliest_name import likeliest_name
from realitygap.diagnose.judge.ordinary import all_done, more_than_usual
from realitygap.diagnose.search.found import Found
from realitygap.diagnose.search.prune import untold
from realitygap.diagnose.search.rivals import Rival


def told_after_all(simulations: Simulations, found: Found, rivals: Mapping[Suspect, Sequence[Rival]]) -> Found:
    """What was found with those of the adjusted named that are names where they are: as far as their intervals tell
    them, they do clearly more than laws are off by, and evidence speaks for them by much more than a name needs
    (`sure_of`), as so many were adjusted at once, and held-out runs too. Of a plant that nobody had seen, names that
    were true gained 62 to 101; of a machine of which nothing was missing, a mass that was 6 % off gained 11. What the
    other values may take over is no more than laws are off by, too: another centre of mass, beside the cable's spring
    that it made stiffer by two thirds, and that did the same without it.

    Args:
        simulations: of the problem.
        found: with what laws are off by adjusted.
        rivals: what could stand in the place of each finding of the search.
    """
    untold_there, told = untold(simulations.problem, found.cautious), list[Suspect]()
    asked = [s for s in found.adjusted if s not in untold_there]
    done = all_done(found) if asked else {}
    for suspect in (s for s in asked if s in done and done[s].unusual and done[s].named(found.limit)):
        rest = [c for c in found.best.fit.changes if c.suspect != suspect]
        without = found.criterion.fit(rest, found.best.fit, "compared")
        if without is None or found.criterion.alike(found.best.fit, without.fit, suspect):
            continue
        gain = found.best.evidence - without.evidence
        named = replace(
            found,
            adjusted=tuple(s for s in found.adjusted if s != suspect),
            gains=found.gains | {suspect: gain},
            without=found.without | {suspect: without},
            rivals=found.rivals | {suspect: list(rivals.get(suspect, ()))},
            least={**found.least, suspect: found.limit},
        )
        if suspect not in sure_of(named) or not more_than_usual(simulations, named, suspect, done[suspect]):
            continue
        if not predicted(simulations, found.floors, found.best.fit.changes, without.fit.changes).worse:
            found = named
            told.append(suspect)
    for suspect in told:
        found = likeliest_name(simulations, found, suspect)
    return found


def untold_after_all(simulations: Simulations, found: Found, keep: Collection[Suspect]) -> tuple[Found, list[Suspect]]:
    """What was found with those adjusted, and not named, whose intervals as they are told hold what the model has
    already; and these. `keep` stays, and what evidence is sure of whose narrower interval does not hold it, where the
    gap of held-out runs is clearly larger without it, the other values fitted anew.

    Of 170 names that 67 machines of three plants which nobody had seen were given, 144 of them true, three had such
    intervals, all false: two inertias and a stop, before which, finding by finding, held-out gaps were 1.04 to 1.14
    times as large. Before the mass of a linear drive, which is 11 % more than in its model, it was 2.1 times.
    """
    sure = sure_of(found)
    open_ = untold(simulations.problem, found.cautious).difference(keep, found.adjusted)
    near = (open_ & sure) - untold(simulations.problem, found.cautious, sure)
    stay = {s for s in near if _clearly_missed(simulations, found, s)}
    vague = [c.suspect for c in found.best.fit.changes if c.suspect in open_ - stay]
    return replace(found, adjusted=(*found.adjusted, *vague)), vague


def usual_after_all(simulations: Simulations, found: Found, keep: Collection[Suspect]) -> tuple[Found, list[Suspect]]:
    """What was found with those adjusted, and not named, that change what the model has by no more than laws of its
    kind may be off by (`USUAL` times what is ordinary), beside what else is adjusted, where the gap of held-out runs is
    not clearly larger without them, the other values fitted anew; and these. `keep` stays.

    Of 51 machines of three plants which nobody had seen, and of 20 of the own one, two names of this kind were false: a
    mass 5 % up where motors lose 2 % of what was recorded, and an inertia, 1.6 and 0.5 times what is ordinary, without
    which the gap was 1.16 and 0.99 times as large. The true ones of that size were sags and ripples, of which a model
    has nothing, as a humanoid without friction has no viscous friction.
    """
    stay = {*keep, *found.adjusted}
    asked = [c.suspect for c in found.best.fit.changes if c.suspect not in stay and _has(simulations, c.suspect)]
    done = all_done(found) if asked else {}
    small = [s for s in asked if s in done and not done[s].unusual and not _clearly_missed(simulations, found, s)]
    return replace(found, adjusted=(*found.adjusted, *small)), small


def _has(simulations: Simulations, suspect: Suspect) -> bool:
    """Whether the model has of its own what a suspect changes, and is no more than off by that."""
    own = neutral(simulations.problem.plant, suspect)
    return suspect.table is None and any(own[p.name] for p in suspect.kind.parameters if not p.shape)


def _clearly_missed(simulations: Simulations, found: Found, suspect: Suspect) -> bool:
    """Whether the gap of held-out runs is clearly larger without a finding, the other values fitted anew."""
    with_ = found.best.fit.changes
    without = found.criterion.fit([c for c in with_ if c.suspect != suspect], found.best.fit, "compared")
    if without is None:
        return True
    before, after = (held_out_gap(simulations, found.floors, of) for of in (without.fit.changes, with_))
    return before > CLEAR * after
