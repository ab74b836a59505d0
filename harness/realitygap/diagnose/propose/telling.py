"""Pieces of motion that are worth a closer look: those where explanations, as they are, predict something else.

Refitted to a motion they come nearer to each other, never farther: what parts nothing before parts nothing after it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.fit.responses import residuals
from realitygap.diagnose.likelihood.floors import Floors
from realitygap.diagnose.likelihood.whitening import channels, spans
from realitygap.diagnose.propose.explanations import Open
from realitygap.robot.drive import Array

MOST = 300
"""So many pieces are looked at with all derivatives at most: 20 s of motion have four or five. One joint or two have
fewer; a humanoid under the gains that it was recorded with has a thousand."""


def telling(simulations: Simulations, open_: Open, cases: Sequence[int], floors: Floors) -> list[int]:
    """The cases that part explanations most, before any of them is refitted, of every question as many; all, where
    there are few, or where nothing is in question.

    Args:
        simulations: of the problem with the motions.
        open_: explanations and questions.
        cases: motions that can be simulated under all of them.
        floors: of all cases.
    """
    if len(cases) <= MOST or not open_.questions:
        return list(cases)
    apart = _apart(simulations, open_, cases, floors)
    best = np.argsort(np.argsort(-apart, axis=1), axis=1).min(axis=0)  # its rank in the question that it tells best
    return [cases[k] for k in np.sort(np.argsort(best, kind="stable")[:MOST])]


def _apart(simulations: Simulations, open_: Open, cases: Sequence[int], floors: Floors) -> Array:
    """How far apart the sides of each question are in each motion, in floors for every second. Shape (q, cases)."""
    found = channels(simulations.problem, floors, cases)
    means = residuals(simulations, [e.fit.changes for e in open_.explanations], cases, floors.coarse)
    out = np.zeros((len(open_.questions), len(cases)))
    number = {case: k for k, case in enumerate(cases)}
    for channel, span in spans(found):
        floor = np.hypot(channel.noise, channel.slow)
        seconds = float(channel.time[-1] - channel.time[0])
        for q, question in enumerate(open_.questions):
            one, other = means[question.one], means[question.other]
            if one is not None and other is not None:
                far = np.nan_to_num(one[span] - other[span]) / floor
                out[q, number[channel.case]] += float(far @ far) / seconds
    return out
