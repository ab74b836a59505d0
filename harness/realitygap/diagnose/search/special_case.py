"""Special cases of laws: whether one says as much as the law, but for what such laws are off by; and as which law."""

from __future__ import annotations

from realitygap.diagnose.candidates.starts import guess
from realitygap.diagnose.candidates.suspects import in_shape_of, neutral
from realitygap.diagnose.data.changes import Change, Suspect, changed
from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.search.criterion import Criterion
from realitygap.diagnose.search.evidence import Scored
from realitygap.diagnose.search.round import MUCH

OTHERWISE = 0.25
"""Of what a law does, in its traces, no more than this may be another shape for it to be a special case. Dry friction
that is 5 % more to one side than to the other parted them by 0.14 and 0.15, as laws are off by, and 14 % more, as of
servos that need telling so, by 0.33 (the bundled demo, viscous friction of 1 and 6 N·m·s/rad beside it); a Stribeck
friction of 1.26 N·m that fell to 0.25, of a geared joint, by 0.44."""


def no_more(
    criterion: Criterion, law: Scored, special: Scored, suspect: Suspect, without: Scored | None, limit: float
) -> bool:
    """Whether a model with a law says no more than the one with a special case of it than such laws are off by, or what
    is too little for a name, whichever was found first.

    Both differ by no more than all of that kind are off by at its joints, which may be more than the law itself does:
    of a geared joint with much viscous friction, a Stribeck friction of 1.26 N·m that fell to 0.25 did half of that,
    and dry friction in its place was 222 behind. Where evidence speaks for the law by `MUCH` times what a name needs,
    it says no more only if that is little of what it does itself.

    Args:
        criterion: by which both are compared.
        law: the model with the law.
        special: the one with the special case in its place.
        suspect: the law.
        without: the model with neither; None where it is not known.
        limit: what a name has to gain.
    """
    more = law.evidence - special.evidence
    if more < limit:
        return True
    if not criterion.alike(law.fit, special.fit, suspect):
        return False
    if without is None or more < MUCH * limit:
        return True
    return criterion.apart(law.fit, special.fit) <= OTHERWISE * criterion.apart(law.fit, without.fit)


def as_law(problem: Problem, special: Change, law: Suspect) -> Change | None:
    """A law with values that do what a special case of it does, from where its own are found: dry friction of 0.2 N·m
    as friction by side of 0.2 to either. None where none of its values say that, as those of a load do not say a mass.

    Args:
        problem: whose scenario has neither.
        special: the special case.
        law: the law.
    """
    plant, first = problem.plant, guess(problem, law)
    said, bare = neutral(changed(plant, [special], plant), law), neutral(plant, law)
    told = {n: said[n] for n in first.free if said[n] != bare[n]}
    return in_shape_of(first.at(told), special) if told else None
