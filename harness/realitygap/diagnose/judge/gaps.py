"""The gap of a model in floors, engine by engine, and what a finding does to runs that were kept back."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from realitygap.diagnose.data.case import JOINT_SIGNALS
from realitygap.diagnose.data.changes import Change, Suspect
from realitygap.diagnose.data.problem import Problem, Signals
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.likelihood.floors import Floors
from realitygap.robot.drive import Array

CLEAR = 1.3
"""A gap up to this many floors leaves nothing to name: floors are known to some 30 % from two or three repetitions."""
WORST = 1e6
"""The gap in floors of a motion that cannot be simulated."""


@dataclass(frozen=True)
class Shown:
    """The held-out gap before and after one finding, in the searching engine and in others; 1 is the floor."""

    before: float
    after: float
    engines: dict[str, tuple[float, float]] = field(default_factory=dict)


def cost(problem: Problem, floors: Floors, case: int, simulated: Signals | None) -> float:
    """The mean squared difference of one motion in floors; 1 is the floor."""
    if simulated is None:
        return WORST**2
    parts = []
    for s in problem.signals(case):
        sigma = problem.deviation(s, floors.sigma(case, s))
        parts.append(((problem.delta(case, s, simulated) / sigma) ** 2).ravel())
    return float(np.nanmean(np.minimum(np.concatenate(parts), WORST**2)))


def costs(
    simulations: Simulations,
    floors: Floors,
    changes: Sequence[Change],
    cases: Sequence[int],
    engine: str | None = None,
) -> dict[int, float]:
    """The cost of some cases with changes, by case."""
    answers = simulations.of(changes, cases, engine=engine)
    return {c: cost(simulations.problem, floors, c, a) for c, a in zip(cases, answers, strict=True)}


def rms(costs: dict[int, float], cases: Sequence[int]) -> float:
    """The gap over some cases, each counting alike: root of the mean cost."""
    return float(np.sqrt(np.mean([costs[c] for c in cases])))


def held_out_gap(simulations: Simulations, floors: Floors, changes: Sequence[Change]) -> float:
    """The gap over the held-out runs with changes, in floors."""
    judge = simulations.problem.of("held_out")
    return rms(costs(simulations, floors, changes, judge), judge)


def joint_gaps(simulations: Simulations, floors: Floors, changes: Sequence[Change]) -> Array:
    """The same of every judged joint alone, all its signals alike; NaN where none of them was measured. Shape (k,)."""
    problem = simulations.problem
    judge = problem.of("held_out")
    parts = [np.zeros((0, int(problem.judged.sum())))]
    for case, answer in zip(judge, simulations.of(changes, judge), strict=True):
        for s in (s for s in problem.signals(case) if s in JOINT_SIGNALS):
            sigma = problem.deviation(s, floors.sigma(case, s))
            off = np.full_like(sigma, WORST) if answer is None else problem.delta(case, s, answer) / sigma
            parts.append(np.minimum(off**2, WORST**2))
    squares = np.concatenate(parts)
    count = np.isfinite(squares).sum(axis=0)
    return np.asarray(np.sqrt(np.where(count > 0, np.nansum(squares, axis=0) / np.maximum(count, 1), np.nan)))


def shown(
    simulations: Simulations, floors: Floors, models: Sequence[Sequence[Change]], engines: Sequence[str]
) -> dict[Suspect, Shown]:
    """The held-out gap before and after each finding, in every engine that can express it, of models of which each has
    one finding more than the one before it, or several.

    The first engine is the one that was searched in.
    """
    judge = simulations.problem.of("held_out")
    asked = [simulations.query(m, c, engine=e) for e in engines for m in models for c in judge]
    simulations.ask(asked)  # side by side; remembered
    gaps = {(e, k): rms(costs(simulations, floors, m, judge, e), judge) for e in engines for k, m in enumerate(models)}
    out = dict[Suspect, Shown]()
    for k, (fewer, more) in enumerate(pairwise(models)):
        known = {c.suspect for c in fewer}
        others = {
            e: (gaps[e, k], gaps[e, k + 1])
            for e in engines[1:]
            if gaps[e, k] < WORST / 10 and gaps[e, k + 1] < WORST / 10
        }
        done = Shown(gaps[engines[0], k], gaps[engines[0], k + 1], others)
        out |= {c.suspect: done for c in more if c.suspect not in known}
    return out


ALIKE = 0.5
"""A finding that lowers the mean square by less than this share of what it does in the searching engine, in every other
engine, mends that engine's own error: what helps in all engines alike has a share of 1, what helps in one alone 0."""


def artefacts(found: dict[Suspect, Shown]) -> list[Suspect]:
    """The findings that help in the searching engine far more than in any other."""
    out = []
    for suspect, s in found.items():
        lowered = s.before**2 - s.after**2
        there = [before**2 - after**2 for before, after in s.engines.values()]
        if there and lowered > 0 and max(there) < ALIKE * lowered:
            out.append(suspect)
    return out
