"""Moves by two steps: through a finding that gains too little alone to what both gain together.

A beam search of width two. Of a joint that lacked a delay of 30 ms, a spring and viscous friction each alone gained
less than what laws leave of a gap of 51 floors, and all three took it to 2.4: only beside the delay the spring had the
largest predicted gain.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

from realitygap.diagnose.data.changes import ModelKey, Suspect, model_key
from realitygap.diagnose.search.evidence import Scored
from realitygap.diagnose.search.grow import grown
from realitygap.diagnose.search.round import Round

THROUGH = 2
"""Models that are gone through: those that gain most, of those that gain what findings need if laws were exact."""


def by_two_steps(round_: Round, keep: Sequence[Suspect], seen: Collection[ModelKey]) -> Scored | None:
    """The best model that one more step leads to from one that gained too little; None where that gains too little
    as well. What both steps gain is asked for as of any other move, by the criterion of the models there. `keep` stays;
    what was `seen` leads nowhere new.
    """
    near = sorted(round_.near, key=lambda s: -round_.spare(s))[:THROUGH]
    for through in near:
        round_.say("through " + "; ".join(str(s) for s in _new(round_.now, through)))
        there = round_.at(through.fit)
        further = grown(there, keep, set(), again=True)
        before = there.criterion.settled(round_.now.fit)
        if further is None or not _new(before, further) or model_key(further.fit.changes) in seen:
            continue
        needs = there.limit * (len(further.fit.changes) - len(before.fit.changes))
        leaves = there.leaves(further, {s.kind.law for s in _new(before, further)}, before)
        if further.evidence - before.evidence >= max(there.asked(further, before, needs), leaves):
            return further
    return None


def _new(before: Scored, after: Scored) -> list[Suspect]:
    """What a model has more than another."""
    here = {c.suspect for c in before.fit.changes}
    return [c.suspect for c in after.fit.changes if c.suspect not in here]
