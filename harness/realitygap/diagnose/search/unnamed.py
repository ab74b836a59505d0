"""The last move: an effort that no law explains, where nothing on the list helps any further."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from realitygap.diagnose.candidates.unnamed import unnamed
from realitygap.diagnose.data.changes import Change, Suspect
from realitygap.diagnose.search.discrepancy import known_to
from realitygap.diagnose.search.evidence import DISCREPANCY_SCALES, Scored
from realitygap.diagnose.search.round import Round

TRIED = 2
"""Ways that are fitted: those of most predicted gain."""


@dataclass(frozen=True)
class _Way:
    """Tables of one joint beside a model, or in the place of its findings there."""

    beside: tuple[Change, ...]
    tables: tuple[Change, ...]

    @property
    def changes(self) -> list[Change]:
        return [*self.beside, *self.tables]


def with_unnamed(round_: Round, keep: Sequence[Suspect]) -> Scored | None:
    """The best model with an unnamed effort at one joint, beside its findings there or in their place; None where none
    gains enough. `keep` stays.

    A table competes as any finding does: each of its values has to be earned, so that a law with one or two values that
    explains as much is the better explanation, and by more than stretches scatter by: dry friction of an arm's joint,
    which gained 15 ± 13, was left out, and a table that gained 18 stayed for it. It has to explain more than ordinary
    laws leave, do more than friction, load and drive may be off by at its joint, and do other than the findings there
    as far off as they may be. A name has to beat it as well: a finding in whose place one gains as much as a name, if
    only by what laws may be off by, is none (`Round.beaten`). An effort around one angle was called a ripple of 7.4
    periods, and gained 154 more.
    """
    best: tuple[float, Scored] | None = None
    for way in _best_ways(round_, keep):
        quick = round_.adjusted(way.changes)
        if quick is None or quick.evidence < round_.now.evidence:
            continue
        scored = round_.criterion.refined(quick)
        if scored is None:
            continue
        gain = scored.evidence - round_.now.evidence
        less, (joint,) = len(round_.now.fit.changes) - len(way.beside), way.tables[0].suspect.indices
        place = f" in place of {less}" if less else ""
        round_.say(f"  {'; '.join(str(t.suspect) for t in way.tables)}{place}: {gain:+.1f}")
        asked = round_.asked(scored, round_.now, round_.limit * len(way.tables))
        needs, spare = max(asked, round_.little(scored)), round_.spare(scored)
        if gain <= needs or _alike(round_, keep, joint, scored):
            continue
        if round_.criterion.ordinary(round_.now, joint, scored.fit):
            round_.beaten.update(c.suspect for c in round_.now.fit.changes if c not in way.beside and less == 1)
        elif best is None or spare > best[0]:
            best = spare, scored
    return None if best is None else best[1]


def _alike(round_: Round, keep: Sequence[Suspect], joint: int, other: Scored) -> bool:
    """Whether what parts another model from the accepted one is no more than its findings at a joint may be off by.

    Of a synthetic arm whose friction grows from rest over 0.03 rad/s, a table over the speed gained 242 in evidence in
    the place of dry and viscous friction, and changed the efforts by 10 % of what these do. Tables in the place of laws
    that were none, as over the angle for a ripple and a centre of mass, changed them by 32 to 48 %.
    """
    now, motions = round_.now.fit, round_.criterion.motions
    there = [c for c in now.changes if c.suspect not in keep and c.suspect.joints == (joint,)]
    without = motions.residual([c for c in now.changes if c not in there]) if there else None
    if without is None:
        return False
    metric = round_.criterion.plain(now).metric  # others take away what laws may be off by, which is asked for here
    do, change = (float(np.linalg.norm(metric(r - now.residual))) for r in (without, other.fit.residual))
    return change <= max(DISCREPANCY_SCALES) * max(known_to(c.suspect) for c in there) * do


def _best_ways(round_: Round, keep: Sequence[Suspect]) -> list[_Way]:
    """The ways that gain most, each simulated as its tables were drawn."""
    criterion, now = round_.criterion, round_.now.fit
    problem = criterion.problem
    joints = [int(j) for j in np.flatnonzero(problem.judged)]
    ways = [_Way(now.changes, tables) for tables in unnamed(problem, now.changes, joints)]
    for j in joints:
        beside = tuple(c for c in now.changes if c.suspect in keep or c.suspect.joints != (j,))
        if len(beside) < len(now.changes):
            ways += [_Way(beside, tables) for tables in unnamed(problem, beside, [j])]
    variants = [now.changes, *(way.changes for way in ways)]
    still, *answers = criterion.motions.residuals(variants)
    gaining = []
    for way, answer in zip(ways, answers, strict=True):
        if still is not None and answer is not None:
            gain = round_.gain(answer - still)
            if gain > 0.0:
                gaining.append((gain, way))
    return [way for _, way in sorted(gaining, key=lambda p: -p[0])[:TRIED]]
