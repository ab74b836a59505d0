"""Values that are named but weak: what a motion does to their intervals, and how long one has to record it."""

from __future__ import annotations

import math

import numpy as np

from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.data.units import unit_there
from realitygap.diagnose.propose.odds import Belief, deviation
from realitygap.diagnose.propose.proposal import Weak
from realitygap.diagnose.result.diagnosis import Z95
from realitygap.diagnose.search.evidence import Scored
from realitygap.robot.drive import Array

LONGEST = 3600.0
"""What is not told in an hour of recording is not told by this motion [s]."""


def weak(problem: Problem, named: Scored, belief: Belief, gram: Array, seconds: float) -> tuple[Weak, ...]:
    """Every fitted value of the named model, the one that is told worst first.

    Args:
        problem: of the recordings.
        named: the model.
        belief: what it knows of its values.
        gram: of the motion.
        seconds: that the motion takes.
    """
    fit = named.fit
    count = len(fit.names)
    now, then = (deviation(g, belief)[:count] for g in (np.zeros_like(gram), gram))
    out = []
    for k, (number, name) in enumerate(fit.names):
        suspect = fit.changes[number].suspect
        wide = Z95 * float(named.deviation[k])  # as the diagnosis says it: wider where stretches scatter
        out.append(
            Weak(
                suspect,
                name,
                unit_there(problem, suspect, suspect.kind.parameter(name)),
                fit.changes[number].parameters[name],
                wide,
                wide * float(then[k] / now[k]),
                _half(belief, gram, k, float(now[k]), seconds),
            )
        )
    return tuple(sorted(out, key=lambda w: -w.now / max(abs(w.value), 1e-12)))


def _half(belief: Belief, gram: Array, k: int, now: float, seconds: float) -> float:
    """How long a motion has to be recorded until a deviation is half of what it is [s].

    What laws may be off by does not average out, so that it may never be.
    """

    def ratio(times: float) -> float:
        return float(deviation(times * gram, belief)[k]) / now

    if ratio(LONGEST / seconds) > 0.5:
        return math.inf
    low, high = 0.0, LONGEST / seconds
    for _ in range(40):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if ratio(middle) <= 0.5 else (middle, high)
    return high * seconds
