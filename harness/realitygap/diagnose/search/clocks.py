"""Discrepancy of time: clocks that run fast, and stamps that are late."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from realitygap.diagnose.candidates.told import CLOCK
from realitygap.diagnose.data.case import JOINT_SIGNALS
from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.likelihood.whitening import Channel, spans
from realitygap.robot.drive import Array

STAMPED = 0.5
"""How well it is known when a motion was sampled, in periods of its recording: stamps are given when data arrive."""


def of_clocks(problem: Problem, channels: Sequence[Channel], residual: Array) -> list[tuple[str, Array]]:
    """What a clock does that runs fast, and stamps that are late, in each motion. Each (m,)."""
    fast, late = np.zeros(len(residual)), {c.case: np.zeros(len(residual)) for c in channels}
    for channel, part in spans(channels):
        if channel.signal in JOINT_SIGNALS:
            time = channel.time
            measured = problem.columns(channel.signal, problem.cases[channel.case].value(channel.signal))
            rate = np.nan_to_num(np.gradient(measured[:, channel.column] + residual[part], time))
            fast[part] = CLOCK * (time - time[0]) * rate
            late[channel.case][part] = STAMPED * float(np.median(np.diff(time))) * rate
    return [("clock", column) for column in (fast, *late.values())]
