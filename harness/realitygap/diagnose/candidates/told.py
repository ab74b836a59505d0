"""What recordings tell by themselves, before physics is blamed: no motion has to be simulated for it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from realitygap.diagnose.candidates.late_speed import late_speed
from realitygap.diagnose.candidates.runs import Seen, standard_errors
from realitygap.diagnose.candidates.slow_velocity import slow_velocity
from realitygap.diagnose.candidates.starts import guess
from realitygap.diagnose.data.changes import Change, Suspect
from realitygap.diagnose.data.problem import Problem
from realitygap.recording.faults import OFF, TIMES

MOST = 0.8
"""The share of the runs that could tell in which a joint must be at fault."""
CLOCK = 1e-3
"""A recorder's clock against the robot's, and a velocity's own, whose scale is no better: 0.1 % is an ordinary
oscillator of a microcontroller, a quartz is better."""
BETWEEN = 0.02
"""What is not known of a time constant since a motion is not known between its samples, in periods of its recording:
planted ones were off by 0.01 to 0.02 (root mean square 0.013), all the same way."""


@dataclass(frozen=True)
class Teller:
    """How an effect is told.

    Attributes:
        names: its parameters, in the order of what is seen.
        seen: what every run that can tell says of a joint.
        same: how far the first of them may differ between joints that share one.
        how: they show it, as the end of a sentence.
    """

    names: tuple[str, ...]
    seen: Callable[[Problem, int], list[Seen]]
    same: float
    how: str


TELLERS = {
    "velocity_filter": Teller(
        ("scale", "time"), slow_velocity, OFF, "the reported velocity is not the derivative of the position"
    ),
    "derivative_lag": Teller(
        ("time",),
        late_speed,
        float(TIMES[1]),
        "the servo's effort is what its law makes of the command, the position and a speed that is so late, and of "
        "nothing else half as well",
    ),
}
"""By effect."""


def told_by_recordings(problem: Problem, suspects: Sequence[Suspect]) -> list[Change]:
    """The effects that the recordings show by themselves, held at the values seen there.

    One for all joints where they have the same, otherwise one per joint.
    """
    return [change for effect in TELLERS for change in _told(problem, [s for s in suspects if s.effect == effect])]


def deviations(problem: Problem, change: Change) -> dict[str, float]:
    """The standard errors of what recordings show of a change, by parameter: how runs scatter, and what none of them
    tells. Where only one can tell, nothing is said.
    """
    teller = TELLERS[change.suspect.effect]
    runs = [run for j in change.suspect.indices if problem.judged[j] for run in teller.seen(problem, j)]
    scatter = standard_errors(runs)
    if scatter is None:
        return {}
    period = max(float(np.median(np.diff(case.measured.time))) for case in problem.cases)
    beside = {"scale": CLOCK * change.parameters.get("scale", 1.0), "time": BETWEEN * period}
    return {name: float(np.hypot(off, beside[name])) for name, off in zip(teller.names, scatter, strict=True)}


def _told(problem: Problem, suspects: Sequence[Suspect]) -> list[Change]:
    """What is told of one effect."""
    if not suspects:
        return []
    teller = TELLERS[suspects[0].effect]
    seen = {int(j): teller.seen(problem, int(j)) for j in np.flatnonzero(problem.judged)}
    tell = {j: runs for j, runs in seen.items() if runs}
    faulty = {j: runs for j, runs in tell.items() if np.mean([run.fault for run in runs]) >= MOST}
    each = [s for s in suspects if len(s.indices) == 1 and s.indices[0] in faulty]
    own = [_change(problem, s, teller, faulty[s.indices[0]]) for s in each]
    everywhere = [s for s in suspects if s.target == "*"]
    alike = np.ptp([change.parameters[teller.names[0]] for change in own]) <= teller.same if own else False
    if everywhere and len(faulty) >= MOST * len(tell) and len(faulty) > 1 and alike:
        return [_change(problem, everywhere[0], teller, [run for runs in faulty.values() for run in runs])]
    return own


def _change(problem: Problem, suspect: Suspect, teller: Teller, runs: Sequence[Seen]) -> Change:
    values = np.median([run.values for run in runs], axis=0)
    return replace(guess(problem, suspect).at(dict(zip(teller.names, values.tolist(), strict=True))), free=())
