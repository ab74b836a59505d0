"""How late the speed is that a servo answers: told by what it was asked, what it saw and what it gave.

Where a recording holds all three, the law of the controller is a straight line through them, whatever the mechanics do:
effort = a·error + b·rate + c (Ljung 1999, equation error). The lag of the rate is what leaves least of the effort, and
it is believed where no other fault of timing leaves as little. Of a pid servo nothing is told: its rate is that of its
error, and a·error + b·late rate is the same line as a late (a·error + (b + a·lag)·rate).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation, convolve1d
from scipy.optimize import minimize_scalar

from realitygap.diagnose.candidates.runs import Z95, Seen, standard_errors
from realitygap.diagnose.data.case import Case
from realitygap.diagnose.data.problem import Problem
from realitygap.recording.faults import SURE, low_pass
from realitygap.robot.drive import PID, SPEED, Array
from realitygap.robot.effects.joint import answers_rate
from realitygap.simulate.profile import told

TIMES = np.array([0.0, 0.25, 0.5, 1.0, 1.5, 2.0, 3.0, 5.0, 8.0])
"""Lags that are tried first, in periods of the recording."""
LONGEST = 0.05
"""The longest lag that is looked for [s]."""
SMOOTH = np.array([1.0, 4.0, 6.0, 4.0, 1.0]) / 16.0
"""What all signals are smoothed with: a quantum of position is none of speed, and what is alike on both sides of a line
does not move it."""
LESS = 4.0
"""The law with a late speed leaves this many times less (sum of squares, half of it rms) than any other, or a run does
not tell: that of the EMPS leaves 92 times less, and noise that calls for a smoother speed is as well served by one that
is not late."""
LIMITED = 0.98
"""An effort above this part of its limit is none of a law."""

Mask = NDArray[np.bool_]
Law = Callable[[float], Array]
"""Of a time [s] the columns that the effort is made of. Shape (t, k)."""


def late_speed(problem: Problem, joint: int) -> list[Seen]:
    """The lag [s] of the speed that a joint's servo answers, of every run that can tell.

    It is a fault of none of them where runs disagree about it by as much as it differs from what the scenario has.
    """
    drive = problem.plant.drive[joint]
    silent = drive["kind"] == PID or answers_rate(problem.plant, joint) is not None
    if silent or problem.file.scenario.effort_measures != "motor":
        return []
    heard = [case for c, case in enumerate(problem.cases) if "effort" in problem.signals(c)]
    out = [seen for case in heard if case.experiment.followed is None and (seen := _seen(case, joint)) is not None]
    error = standard_errors([run for run in out if run.fault])
    differs = abs(float(np.median([run.values for run in out])) - drive["derivative_lag"]) if out else 0.0
    agreed = error is not None and differs > Z95 * error[0]
    return out if agreed else [replace(run, fault=False) for run in out]


def _seen(case: Case, joint: int) -> Seen | None:
    """The lag of one run, and whether it is a fault; None where the controller's law does not explain its effort, or
    explains it as well with no such lag.
    """
    plant, time = case.experiment.plant, case.measured.time
    drive, period = plant.drive[joint], float(np.median(np.diff(time)))
    even = np.arange(time[0], time[-1], period)
    if len(even) < 10 * len(SMOOTH):
        return None
    commands = case.experiment.commands
    commands = replace(commands, time=commands.time + case.experiment.begin - even[0])
    command = told(commands, plant.drive, len(even), period, plant.delay)[:, joint]
    position, effort = (np.interp(even, time, case.value(s)[:, joint]) for s in ("position", "effort"))
    lost = ~(np.isfinite(command) & np.isfinite(position))
    limited = ~(np.abs(effort) < LIMITED * min(drive["effort_limit"], drive["real_limit"]))
    memory = max(int(5.0 * LONGEST / period), 1)  # until a lag has forgotten what was before
    known = ~(binary_dilation(lost, iterations=memory) | binary_dilation(limited, iterations=len(SMOOTH)))
    known[:memory] = False
    if known.sum() < 10 * len(SMOOTH) or not np.ptp(effort[known]):  # an effort that never changes tells of no lag
        return None
    command, position, effort = (np.nan_to_num(value) for value in (command, position, effort))

    def made(late: float = 0.0, asked: float = 0.0, smooth: float = 0.0) -> Array:
        goal = low_pass(command, asked, period)
        error = goal if drive["kind"] == SPEED else goal - position
        rate = low_pass(np.gradient(-position, period), late, period)
        if smooth > 0.0:  # as calm as a lag makes it, but not late
            rate = low_pass(low_pass(rate, smooth / 2.0, period)[::-1], smooth / 2.0, period)[::-1]
        columns = np.column_stack([error, rate, np.ones_like(error)])
        return np.asarray(convolve1d(columns, SMOOTH, axis=0, mode="nearest"))

    given = convolve1d(effort, SMOOTH, mode="nearest")
    own = float(drive["derivative_lag"])
    stated = made(late=own)
    ways: list[Law] = [
        lambda t: made(late=t),
        lambda t: made(late=own, asked=t),
        lambda t: made(late=own, smooth=t),
        lambda t: np.column_stack([low_pass(column, t, period) for column in stated.T]),
    ]
    (lag, left), *others = (_best(law, given, known, period) for law in ways)
    other = min(_left(stated, given, known), *(rest for _, rest in others))
    explained = 1.0 - min(left, other) / float(np.sum((given[known] - given[known].mean()) ** 2))
    if explained < SURE**2 or max(left, other) < LESS * min(left, other):
        return None
    return Seen((lag,), left < other)


def _best(law: Law, given: Array, known: Mask, period: float) -> tuple[float, float]:
    """The time [s] of a law with which it leaves least, and what it leaves: the sum of squares."""
    tried = [t for t in TIMES * period if t <= LONGEST]
    rest = [_left(law(t), given, known) for t in tried]
    at = int(np.argmin(rest))
    ends = tried[max(at - 1, 0)], tried[min(at + 1, len(tried) - 1)]
    finest = minimize_scalar(lambda t: _left(law(t), given, known), bounds=ends, method="bounded")
    return (float(finest.x), float(finest.fun)) if finest.fun < rest[at] else (tried[at], rest[at])


def _left(columns: Array, given: Array, known: Mask) -> float:
    """What a straight line through columns leaves of an effort: the sum of squares."""
    x, y = columns[known], given[known]
    return float(np.sum((y - x @ np.linalg.lstsq(x, y, rcond=None)[0]) ** 2))
