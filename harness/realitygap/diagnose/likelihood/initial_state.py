"""The initial state's spread: how far the measured state at which a window begins may be off, and every sample with it.

Propagated by simulations from states that are drawn (Monte Carlo).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from realitygap.diagnose.data.changes import Change
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.data.worker import Query
from realitygap.robot.drive import Array

TRIES = 4
"""States that the readings allow as well and that are tried: their spread is known to a third."""


def initial_state_spread(
    simulations: Simulations, changes: Sequence[Change], cases: Sequence[int]
) -> list[dict[str, Array]]:
    """The standard deviation of each sample of cases with windows, by signal, shape (t, n); empty for other cases."""
    problem = simulations.problem
    cut = [c for c in cases if problem.cases[c].windows]
    seeds = (None, *range(TRIES))
    answers = simulations.ask([Query(tuple(changes), c, problem.engine, nudge=seed) for c in cut for seed in seeds])
    out: list[dict[str, Array]] = [{} for _ in problem.cases]
    for k, c in enumerate(cut):
        still, *nudged = answers[k * len(seeds) : (k + 1) * len(seeds)]
        good = [a for a in nudged if a is not None]
        if still is not None and good:
            signals = problem.signals(c)
            out[c] = {s: np.sqrt(np.mean([(a[s] - still[s]) ** 2 for a in good], axis=0)) for s in signals}
    return out
