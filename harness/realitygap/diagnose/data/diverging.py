"""How soon a simulated motion forgets how it began: for what was thrown or let go once, so that no repetition tells.

The motion is simulated from its measured start and from others that the readings allow as well. Where they come far
further apart than they began, no model can follow the rest of that recording sample by sample, however right it is.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from realitygap_engines import Diverged, Failed, Unsupported

from realitygap.diagnose.data.case import Case
from realitygap.diagnose.data.windows import cut
from realitygap.robot.drive import Array
from realitygap.simulate.experiment import Experiment, simulate

TRIES = 4
"""Other starts that are tried."""
FAR = 5.0
"""A motion is forgotten where they come further apart than this (rms), in standard deviations of a reading and of what
the start's errors come to while nothing but time makes them grow."""


def let_go(experiment: Experiment) -> bool:
    """Whether something moves that nothing holds: a body without joints, or a servo that is off for a time."""
    free = experiment.scenario.robot.base == "free"
    return free or bool(np.isnan(experiment.commands.value).any())


def forgotten(case: Case, engine: str) -> float | None:
    """How long after its start [s] a motion is still told by it; None where it is to its end, or cannot be told."""
    time = case.measured.time
    whole = cut(case, float(np.inf)).windows
    if not whole:
        return None
    try:
        far = _apart(case, whole[0], engine)
    except (Diverged, Failed, Unsupported):
        return None
    return float(time[int(np.argmax(far > FAR))] - time[0]) if far.max() > FAR else None


def _apart(case: Case, start: Experiment, engine: str) -> Array:
    """How far simulations from measured starts come apart, as `FAR` counts it. Shape (t,)."""
    random = np.random.default_rng(0)
    assert start.midway is not None
    starts = [start, *(replace(start, midway=start.midway.nudged(random)) for _ in range(TRIES))]
    still, *others = (simulate(e, engine).trace.at(case.measured.time) for e in starts)
    elapsed = (case.measured.time - case.measured.time[0])[:, None]
    squares = [
        np.mean([(getattr(o, s) - getattr(still, s)) ** 2 for o in others], axis=0)
        / (case.noise[s] ** 2 + place**2 + (speed * elapsed) ** 2)
        for s, (place, speed) in start.midway.errors.items()
        if s in case.noise
    ]
    return np.asarray(np.sqrt(np.max(np.hstack(squares), axis=1)))
