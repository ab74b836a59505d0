"""Pieces of motion that are worth a closer look: those where explanations, as they are, predict something else.

Refitted to a motion they come nearer to each other, never farther: what parts nothing before parts nothing after it.
Where nothing is in question, only the derivatives of a closer look say which pieces are worth it: some of every kind
are.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

import numpy as np

from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.likelihood.floors import Floors
from realitygap.diagnose.likelihood.whitening import channels, stacked
from realitygap.diagnose.propose.explanations import Open
from realitygap.diagnose.propose.safe import simulated
from realitygap.robot.drive import Array

Item = TypeVar("Item")

MOST = 2000
"""So many pieces of one joint are looked at with all derivatives at most, and of more joints as many fewer, as a step
takes longer: 100 of a humanoid, which under all gains that it was recorded with has 1500, and of which 20 s of motion
take four or five."""


def telling(simulations: Simulations, open_: Open, cases: Sequence[int], floors: Floors, most: int = MOST) -> list[int]:
    """The cases that part explanations most, before any of them is refitted, of every question as many; evenly drawn
    ones, where nothing is in question; all, where there are few.

    Args:
        simulations: of the problem with the motions.
        open_: explanations and questions.
        cases: motions.
        floors: of all cases.
        most: how many at most, of a robot with one joint.
    """
    number = most // len(simulations.problem.judged)
    if len(cases) <= number:
        return list(cases)
    if not open_.questions:  # listed by direction and kind
        return evenly(cases, number)
    apart = _apart(simulations, open_, cases, floors)
    best = np.argsort(np.argsort(-apart, axis=1), axis=1).min(axis=0)  # its rank in the question that it tells best
    return [cases[k] for k in np.sort(np.argsort(best, kind="stable")[:number])]


def evenly(every: Sequence[Item], most: int) -> list[Item]:
    """So many of them, from the first one on as far apart as they are listed."""
    return [every[k] for k in np.unique(np.linspace(0, len(every) - 1, min(len(every), most)).round().astype(int))]


def _apart(simulations: Simulations, open_: Open, cases: Sequence[int], floors: Floors) -> Array:
    """How far apart the sides of each question are in each motion, in floors for every second; 0 where one of them
    cannot be simulated. Shape (q, cases).
    """
    problem, out = simulations.problem, np.zeros((len(open_.questions), len(cases)))
    told = simulated(simulations, open_.explanations, cases, floors)
    for k, case in enumerate(cases):
        own = channels(problem, floors, [case])
        floor = np.concatenate([np.hypot(c.noise, c.slow) for c in own])
        here = [None if a is None else stacked(problem, [case], [a]) / floor for a in told[k]]
        for q, question in enumerate(open_.questions):
            one, other = here[question.one], here[question.other]
            if one is not None and other is not None:
                out[q, k] = float(np.nansum((one - other) ** 2)) / float(np.ptp(own[0].time))
    return out
