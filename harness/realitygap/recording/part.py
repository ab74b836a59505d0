"""A part of a recording: what a long one is cut to before it is simulated."""

from dataclasses import replace

import numpy as np

from realitygap.files.errors import InputError
from realitygap.files.found import counted
from realitygap.recording.commands import held_at
from realitygap.recording.recording import Recording
from realitygap.recording.streams import Request


def part_of(recording: Recording, request: Request) -> Recording:
    """The recording between the times that the scenario names, on its own clock; all of it where none are named.

    The command that is in force when the part begins stands at its begin.

    Raises:
        InputError: for a part with fewer than two samples.
    """
    span = request.recordings.part
    if span is None:
        return recording
    start, end = span
    whole = recording.trace.time
    keep = (whole >= start) & (whole <= end)
    if keep.sum() < 2:
        raise InputError(
            f"{request.file}: recordings: part [{start:g}, {end:g}] holds {counted(int(keep.sum()), 'sample')} of "
            f"{recording.path}, which lasts from {whole[0]:.2f} to {whole[-1]:.2f} s; expected at least two"
        )
    trace = recording.trace.rows(keep)
    begin = float(trace.time[0])
    time, command = recording.command_time, recording.command
    if len(time):
        later = (time > begin) & (time <= end)
        command = np.vstack([held_at(time, command, np.array([begin])), command[later]])
        time = np.concatenate([[begin], time[later]])
    receive = recording.receive_time
    return replace(
        recording,
        trace=trace,
        command_time=time,
        command=command,
        receive_time=None if receive is None else receive[keep],
        outliers=tuple(o for o in recording.outliers if start <= o.time <= end),
    )
