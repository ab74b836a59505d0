"""Whether a special case of a law says as much as the law, but for what such laws are off by."""

from __future__ import annotations

from realitygap.diagnose.data.changes import Suspect
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
