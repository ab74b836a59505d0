"""Advice where a derivative gain makes spikes of the steps of held commands: no mistake, as buses hold commands."""

import numpy as np

from realitygap.check.observed import Observed, Read, observe
from realitygap.check.servo import limit
from realitygap.check.words import effort_unit, joined
from realitygap.recording import read_recording
from realitygap.recording.commands import usual_period
from realitygap.robot.drive import PID
from realitygap.scenario.file import ScenarioFile

SLOWER = 1.5
"""Steps of the simulation that a command lasts where it is held for longer than one."""
SLOWEST = 0.1
"""s: commands that come more rarely are goals, and none of a trajectory."""


def advice(file: ScenarioFile, read: Read = read_recording) -> list[str]:
    """A sentence where a derivative gain gives more for the steps of held commands than all that was measured, told of
    the recording in which that is worst.

    Raises:
        InputError: for what cannot be read.
    """
    found = [told for o in observe(file, read) if (told := _spikes(o)) is not None]
    return [max(found)[1]] if found else []


def _spikes(o: Observed) -> tuple[float, str] | None:
    """How many times the measured effort the spikes are, in the mean square over time, and the sentence: `kd` times a
    step of the command, within two steps of the simulation, so that half the time step doubles them.
    """
    motion, period, d = o.scenario.motion, usual_period(o.recording.command_time), o.plant.drive
    step = 1.0 / o.scenario.physics.step_rate
    if motion is None or not motion.held or o.effort is None or period is None:
        return None
    if not SLOWER * step < period <= SLOWEST:
        return None
    change = np.nan_to_num(np.abs(np.diff(o.recording.command, axis=0)))
    spike = np.minimum(d["kd"] * change / (2.0 * step), limit(o))
    given = np.sqrt((spike**2).mean(axis=0) * 2.0 * step / period)
    known = np.isfinite(o.effort)
    measured = np.sqrt((np.where(known, o.effort, 0.0) ** 2).sum(axis=0) / np.maximum(known.sum(axis=0), 1))
    takes_rate = (d["kind"] == PID) & (d["derivative_lag"] == 0.0)
    worse = np.flatnonzero(o.follows & takes_rate & (given > measured) & (measured > 0.0))
    if not len(worse):
        return None
    j = int(worse[np.argmax(given[worse] / measured[worse])])
    unit, names = effort_unit(o, j), joined([o.joints[i] for i in worse])
    return float(given[j] / measured[j]), (
        f"{o.name}: of commands that are held for {1e3 * period:.3g} ms, kd makes spikes of effort at {names}: "
        f"{given[j]:.3g} {unit} at {o.joints[j]} (rms), where {measured[j]:.3g} {unit} were measured, and more at a "
        "higher step rate; `held: false` in motion takes commands as samples of a trajectory, and makes none"
    )
