"""How soon a simulated motion forgets how it began: for what was thrown or let go once, so that no repetition tells.

The motion is simulated from its measured start and from others that the readings allow as well. Where they come far
further apart than they began, no model can follow the rest of that recording sample by sample, however right it is.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from realitygap_engines import Diverged, Failed, Unsupported

from realitygap.diagnose.data.case import Case
from realitygap.diagnose.data.windows import begun
from realitygap.robot.drive import TORQUE, Array
from realitygap.simulate.experiment import Experiment, simulate

TRIES = 4
"""Other starts that are tried."""
ALONG = 8
"""Moments of a motion from which it is simulated, where efforts drove it."""
FAR = 5.0
"""A motion is forgotten where they come further apart than this (rms), in standard deviations of a reading and of what
the start's errors come to while nothing but time makes them grow."""


def let_go(experiment: Experiment) -> bool:
    """Whether something moves that nothing holds: a body without joints, a motor that is told efforts, or a servo that
    is off for a time.
    """
    free = experiment.scenario.robot.base == "free"
    return free or told_efforts(experiment) or bool(np.isnan(experiment.commands.value).any())


def told_efforts(experiment: Experiment) -> bool:
    """Whether a motor is told efforts, wherever they take its joint."""
    return bool((experiment.plant.drive["kind"] == TORQUE).any())


def forgotten(case: Case, engine: str) -> float | None:
    """How long after its start [s] a motion is still told by it; None where it is to its end, or cannot be told.

    Whoever told a motor its efforts saw where these took it, as the model does not: what it held, as an arm upright,
    falls without it, wherever a simulation begins. So of these motions other starts on their way are asked too, and the
    one that is forgotten first counts.
    """
    begins = begun(case, ALONG if told_efforts(case.experiment) else 1)
    untils = [until for begin in begins if (until := _until(case, begin, engine)) is not None]
    return min(untils, default=None)


def _until(case: Case, start: Experiment, engine: str) -> float | None:
    """The same of one start."""
    time = case.measured.time[case.measured.time >= start.begin]
    try:
        far = _apart(case, time, start, engine)
    except (Diverged, Failed, Unsupported):
        return None
    return float(time[int(np.argmax(far > FAR))] - time[0]) if far.max() > FAR else None


def _apart(case: Case, time: Array, start: Experiment, engine: str) -> Array:
    """How far simulations from measured starts come apart at times [s], as `FAR` counts it. Shape (t,)."""
    random = np.random.default_rng(0)
    assert start.midway is not None
    starts = [start, *(replace(start, midway=start.midway.nudged(random)) for _ in range(TRIES))]
    still, *others = (simulate(e, engine).trace.at(time) for e in starts)
    elapsed = (time - time[0])[:, None]
    squares = [
        np.mean([(getattr(o, s) - getattr(still, s)) ** 2 for o in others], axis=0)
        / (case.noise[s] ** 2 + place**2 + (speed * elapsed) ** 2)
        for s, (place, speed) in start.midway.errors.items()
        if s in case.noise
    ]
    return np.asarray(np.sqrt(np.max(np.hstack(squares), axis=1)))
