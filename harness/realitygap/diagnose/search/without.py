"""A model without one of its findings: what is lost says whether it is needed."""

from __future__ import annotations

from collections.abc import Sequence

from realitygap.diagnose.data.changes import Change, Suspect
from realitygap.diagnose.fit.fit import CHEAP
from realitygap.diagnose.search.evidence import EQUAL, Scored
from realitygap.diagnose.search.grow import with_shape
from realitygap.diagnose.search.rivals import CLOSE, ODDS
from realitygap.diagnose.search.round import Round

PLAIN = 3.0
"""What is lost without a finding is worked out in full below this many times what a name needs."""


def without(round_: Round, now: Scored, suspect: Suspect) -> Scored | None:
    """A model without one of its findings, refitted; with a shape of what is left at its joints where that says the
    same with no more values. Where it says more it is no other word for the finding, but a move of its own. A spring
    that rests at 0.21 rad was told as one that rests at zero, beside a constant effort.
    """
    plain = _left_out(round_, now, suspect)
    if plain is None or not round_.earned(now, plain, round_.limit):
        return plain
    rest, plant = plain.fit.changes, round_.simulations.problem.plant
    near = [_beside(c, suspect) for c in rest]
    shaped = [with_shape(plant, c, 1.0) if there else c for c, there in zip(rest, near, strict=True)]
    more = _values(shaped) - _values(rest)
    if not 0 < more <= _values(now.fit.changes) - _values(rest):
        return plain
    quick = round_.adjusted(shaped, plain.fit)
    if quick is None or quick.evidence - plain.evidence < CLOSE * (now.evidence - plain.evidence):
        return plain
    full = round_.criterion.refined(quick)
    return full if full is not None and -EQUAL < full.evidence - now.evidence < ODDS else plain


def _beside(change: Change, suspect: Suspect) -> bool:
    """Whether a finding with values of its own sits at a joint of another one."""
    return bool(change.free) and not set(change.suspect.joints).isdisjoint(suspect.joints)


def _values(changes: Sequence[Change]) -> int:
    """How many values are fitted."""
    return sum(len(c.free) for c in changes)


def _left_out(round_: Round, now: Scored, suspect: Suspect) -> Scored | None:
    """A model without one of its findings, refitted; in full where a quick fit leaves open whether it is missed, or
    what else is at its joints may make up for it by going far: of an elbow that lacked neither, another gain, 2.1 times
    as high, another torque constant, 0.48 times as high, and viscous friction were as good as none of the three, and
    two steps without one of them lost 350 to 3100.

    Where that leaves it open still, with derivatives of where it is: with those of the model that has it, a fit without
    a profile ended 0.4 ms from the best delay, and 13.7 in evidence behind it. Not so with many values, of which
    derivatives cost more than all else.
    """
    rest = [c for c in now.fit.changes if c.suspect != suspect]
    quick = round_.adjusted(rest, now.fit)
    many = _values(rest) >= CHEAP
    alone = many or not any(_beside(c, suspect) for c in rest)
    if quick is not None and alone and now.evidence - quick.evidence > PLAIN * round_.limit:
        return quick
    near = None if quick is None else round_.criterion.refined(quick)
    if near is not None and (many or now.evidence - near.evidence > PLAIN * round_.limit):
        return near
    anew = round_.criterion.fit(rest if near is None else near.fit.changes, care="compared")
    return max((s for s in (near, anew) if s is not None), key=lambda s: s.evidence, default=None)
