"""Velocities that are no derivatives: told from the recordings alone, before physics is blamed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.special import ndtri, stdtrit

from realitygap.diagnose.candidates.starts import guess
from realitygap.diagnose.data.changes import Change, Suspect
from realitygap.diagnose.data.problem import Problem
from realitygap.recording.faults import OFF, SURE, at_fault, velocity_of_position

MOST = 0.8
"""The share of the runs that could tell in which a joint's velocity must be at fault."""
CLOCK = 1e-3
"""A recorder's clock against the robot's, and a velocity's own, whose scale is no better: 0.1 % is an ordinary
oscillator of a microcontroller, a quartz is better."""
BETWEEN = 0.02
"""What is not known of a time constant since a motion is not known between its samples, in periods of its recording:
planted ones were off by 0.01 to 0.02 (root mean square 0.013), all the same way."""


def velocity_filters(problem: Problem, suspects: Sequence[Suspect]) -> list[Change]:
    """The velocity filters that the recordings show by themselves, held at the scale and time constant seen there.

    One for all joints where they have the same, otherwise one per joint.
    """
    filters = [s for s in suspects if s.effect == "velocity_filter"]
    seen = {int(j): _seen(problem, int(j)) for j in np.flatnonzero(problem.judged)}
    told = {j: rows for j, rows in seen.items() if rows}
    faulty = {j: rows for j, rows in told.items() if np.mean([bad for *_, bad in rows]) >= MOST}
    own = [_change(problem, s, faulty[s.indices[0]]) for s in filters if len(s.indices) == 1 and s.indices[0] in faulty]
    everywhere = [s for s in filters if s.target == "*"]
    if everywhere and len(faulty) >= MOST * len(told) and len(faulty) > 1 and _alike(own):
        return [_change(problem, everywhere[0], [row for rows in faulty.values() for row in rows])]
    return own


def deviations(problem: Problem, change: Change) -> dict[str, float]:
    """The standard errors of what recordings show of a velocity filter, by parameter: how runs scatter, and what none
    of them tells. Of few runs they are as much larger as Student's distribution is wider than a normal one; where only
    one can tell, nothing is said.
    """
    rows = [row for j in change.suspect.indices if problem.judged[j] for row in _seen(problem, j)]
    if len(rows) < 2:
        return {}
    wider = float(stdtrit(len(rows) - 1, 0.975) / ndtri(0.975))
    scale, time = np.std([row[:2] for row in rows], axis=0, ddof=1) * wider / np.sqrt(len(rows))
    period = max(float(np.median(np.diff(case.measured.time))) for case in problem.cases)
    return {
        "scale": float(np.hypot(scale, CLOCK * change.parameters["scale"])),
        "time": float(np.hypot(time, BETWEEN * period)),
    }


def _alike(own: Sequence[Change]) -> bool:
    """Whether joints have one scale, as far as a scale is told."""
    scales = np.array([change.parameters["scale"] for change in own])
    return bool(np.ptp(scales) <= OFF)


def _seen(problem: Problem, joint: int) -> list[tuple[float, float, bool]]:
    """Scale, time constant [s] and whether they are a fault, of every run that can tell."""
    out = []
    for c, case in enumerate(problem.cases):
        if "velocity" not in problem.signals(c):
            continue
        time = case.measured.time
        fit = velocity_of_position(time, case.value("position")[:, joint], case.value("velocity")[:, joint])
        if fit is not None and abs(fit[2]) > SURE:
            out.append((fit[0], fit[1], at_fault(*fit, float(np.median(np.diff(time))))))
    return out


def _change(problem: Problem, suspect: Suspect, rows: Sequence[tuple[float, float, bool]]) -> Change:
    scale, constant = (float(np.median([row[k] for row in rows])) for k in (0, 1))
    return replace(guess(problem, suspect).at({"scale": scale, "time": constant}), free=())
