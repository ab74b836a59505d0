"""What does the same as a finding, told by responses beside the finding rather than where it is missing.

Where a finding that explains most is missing, a motion goes another way, and the linearised model there tells little of
where a rival leads: of a pendulum that was swung up, all of friction, limits and springs had more predicted gain than
the mass that was missing, and a gain, which does what a mass does, only half of it. Beside the finding responses are
short and linear: what the finding does there, a rival that cannot be told from it does too.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import islice

import numpy as np

from realitygap.diagnose.candidates.suspects import neutral
from realitygap.diagnose.data.changes import Change, Suspect
from realitygap.diagnose.fit.fit import Fit
from realitygap.diagnose.fit.responses import Block
from realitygap.diagnose.search.criterion import Criterion
from realitygap.diagnose.search.linear import Linear
from realitygap.diagnose.search.round import Round

MOST = 0.8
"""Those are told that do more than this share of what the finding does, in squares, as if laws were exact: what laws
may be off by hides that two do the same. Of a pendulum that was swung up a gain did 0.88 of what its mass does, as far
as the linearised model tells, and of one that swings 0.995.
"""
OF_THE_LAW = 0.25
"""The same for what changes the same law at the same joints, which fits bend most: beside a torque ripple the mass of a
link did 0.42 of what its centre does, and was 290 ahead in evidence once it was fitted in its place.
"""
FEW, FEW_OF_THE_LAW = 2, 4
"""So many of either, those that do most."""


def alike(round_: Round, *findings: Change) -> dict[Suspect, Change]:
    """Suspects that do most of what findings do at the model of a round (`same`)."""
    return same(round_.criterion, round_.now.fit, findings, round_.blocks)


def same(
    criterion: Criterion, fit: Fit, findings: Sequence[Change], blocks: Sequence[Block], few: int = FEW
) -> dict[Suspect, Change]:
    """Suspects that stand beside a finding, or several, and do most of what these do, and how much of each does: the
    best few.

    Args:
        criterion: of the search.
        fit: of the model with the findings.
        findings: changes of it, which are all of one law at the same joints.
        blocks: responses there of the suspects.
        few: how many of those that do most of it.
    """
    blocks = [b for b in blocks if b.start.kind != "whole"]
    lines = in_place(criterion, fit, findings, blocks)
    if lines is None:
        return {}
    whole = 0.5 * float(lines.gram[0, 0])
    done = [lines.gain([i]) for i in range(len(blocks))]
    most: dict[Suspect, Change] = {}
    of_the_law: dict[Suspect, Change] = {}
    for i in sorted(range(len(blocks)), key=lambda i: -done[i]):
        suspect = blocks[i].suspect
        if done[i] > MOST * whole:
            most.setdefault(suspect, lines.gain_of(i).change)
        elif done[i] > OF_THE_LAW * whole and _of_the_law(suspect, findings[0].suspect):
            of_the_law.setdefault(suspect, lines.gain_of(i).change)
    return dict([*islice(most.items(), few), *islice(of_the_law.items(), FEW_OF_THE_LAW)])


def in_place(criterion: Criterion, fit: Fit, findings: Sequence[Change], blocks: Sequence[Block]) -> Linear | None:
    """The linearised model of what could stand in the place of findings, beside them; None where there is none.

    Args:
        criterion: of the search.
        fit: of the model with the findings.
        findings: changes of it.
        blocks: responses there of what could.
    """
    plant, known = criterion.problem.plant, {c.suspect: c for c in findings}
    own = np.array([fit.changes[i].suspect in known for i, _ in fit.names], dtype=bool)
    of = [(known[fit.changes[i].suspect], n) for (i, n), o in zip(fit.names, own, strict=True) if o]
    away = np.array([c.parameters[n] - neutral(plant, c.suspect)[n] for c, n in of])
    if not np.isfinite(away).all() or not away.any() or not blocks:
        return None  # a limit or a stiffness, which is not undone by a straight line
    does = fit.slope[:, own] @ (away / fit.size[own])
    return Linear(criterion.plain(fit).metric, -does, fit.slope[:, ~own], blocks)


def _of_the_law(suspect: Suspect, finding: Suspect) -> bool:
    """Whether it changes the same law as a finding, at the same joints."""
    return suspect.kind.law == finding.kind.law != "" and set(suspect.joints) == set(finding.joints)
