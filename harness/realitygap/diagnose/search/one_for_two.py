"""Moves that let one finding take the place of two of the same law at the same joints.

What a link lacks is easily taken for two things of it that undo most of one another: of a link whose inertia was 3.2
times as large, a load far behind its joint was made and a mass, and no exchange of either one leads back.
"""

from __future__ import annotations

from itertools import combinations

from realitygap.diagnose.data.changes import stands_beside
from realitygap.diagnose.search.alike import alike
from realitygap.diagnose.search.grow import Ways
from realitygap.diagnose.search.round import Round


def one_for_two(round_: Round) -> Ways:
    """Models with what does most of what two findings do together in their place, and the evidence that each may lose:
    what one finding had to gain.
    """
    accepted, ways = round_.now.fit.changes, []
    for a, b in combinations([c for c in accepted if c.free], 2):
        law = a.suspect.kind.law
        if not law or law != b.suspect.kind.law or set(a.suspect.joints) != set(b.suspect.joints):
            continue
        rest = [c for c in accepted if c not in (a, b)]
        for suspect, change in alike(round_, a, b).items():
            if stands_beside(suspect, [c.suspect for c in rest]):
                ways.append(([*rest, change], -round_.limit))
    return ways
