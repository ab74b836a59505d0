"""Commands that are samples of a trajectory, or goals that are held: told by how often they change, and by how much."""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from realitygap.init.sections import Sections
from realitygap.recording import Recording
from realitygap.recording.commands import usual_period
from realitygap.scenario.file import ScenarioFile
from realitygap.scenario.servos import PidServo

LONGEST = 0.02
"""s: commands that come more rarely are seen as steps by servo and joint, too."""
RUNS_ON = 0.8
"""The share of changes that are followed by another in the next sample, at least: steps are followed by none."""
SMALL = 0.05
"""The share of a joint's reach that a usual change of its command is, at most."""


def between_samples(file: ScenarioFile, sections: Sections, recordings: Iterable[Recording]) -> Sections | None:
    """The sections with commands that are joined by lines; None where they are held.

    A servo with `kd` makes a spike of effort of every step of a held command, which hides all other effort. Where the
    commands were streamed from a trajectory, there are no steps in what the controller asked for; where they step,
    they are held, and the spikes are few.

    Args:
        file: the draft.
        sections: of the draft.
        recordings: all of the draft.
    """
    if not sections.motion.holds or not any(isinstance(s, PidServo) and s.kd > 0 for s in file.scenario.servos):
        return None
    periods = [_period(recording) for recording in recordings]
    known = [period for period in periods if period is not None]
    if not known or len(known) < len(periods):
        return None
    why = f"commands come every {1e3 * max(known):.3g} ms and change by little: samples of a trajectory"
    return replace(sections, motion=sections.motion.between(f"{why}; held: true makes steps of them"))


def _period(recording: Recording) -> float | None:
    """The period [s] of commands that are samples of a trajectory; None for others, and where there are none."""
    period = usual_period(recording.command_time)
    if period is None or period > LONGEST:
        return None
    change = np.nan_to_num(np.abs(np.diff(recording.command, axis=0)))
    moved = change > 0
    if not moved.any():
        return None
    runs_on = (moved[:-1] & moved[1:]).sum() / max(moved[:-1].sum(), 1)
    columns = zip(change.T, moved.T, recording.command.T, strict=True)
    usual = max(np.median(c[m]) / np.ptp(asked[np.isfinite(asked)]) for c, m, asked in columns if m.any())
    return period if runs_on >= RUNS_ON and usual <= SMALL else None
