"""Joints that mimic others and were not recorded: they have no freedom of their own, and stand as their leaders say."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np
from realitygap_engines.model.robot import Mimic

from realitygap.files.errors import InputError
from realitygap.recording.recording import Recording
from realitygap.trace.trace import Array

RATES = {"position": False, "velocity": True}
"""The joint signals that a leader tells, and whether they are rates, which no offset changes."""


def with_followers(
    read: Callable[[Sequence[str]], Recording], joints: tuple[str, ...], mimics: Mapping[str, Mimic]
) -> Recording:
    """A recording of all joints; where it cannot be read with those that mimic others, these are told from the others.

    Position, velocity and a command of either are what the leader's make of them; an effort or a temperature is NaN,
    as nothing tells it.

    Args:
        read: reads the recording of some joints.
        joints: all joints, in the order of the columns.
        mimics: the joints that follow others, by name.

    Raises:
        InputError: as `read` does of all joints, where it does of those that are free, too.
    """
    try:
        return read(joints)
    except InputError as error:
        free = tuple(joint for joint in joints if joint not in mimics)
        led = {joint: mimics[joint] for joint in joints if joint in mimics and mimics[joint].joint in free}
        if not led or len(free) + len(led) < len(joints):
            raise
        try:
            recording = read(free)
        except InputError:
            raise error from None
        return _completed(recording, joints, led, str(error))


def _completed(recording: Recording, joints: tuple[str, ...], led: Mapping[str, Mimic], why: str) -> Recording:
    trace, free = recording.trace, recording.trace.joints
    kind = recording.command_kind or ""

    def columns(value: Array, signal: str) -> Array:
        out = np.full((len(value), len(joints)), np.nan)
        for j, joint in enumerate(joints):
            if joint not in led:
                out[:, j] = value[:, free.index(joint)]
            elif signal in RATES:
                mimic = led[joint]
                offset = 0.0 if RATES[signal] else mimic.offset
                out[:, j] = mimic.multiplier * value[:, free.index(mimic.joint)] + offset
        return out

    of_joints = ("position", "velocity", "effort", "command", "temperature")
    found = {s: value for s in of_joints if (value := getattr(trace, s)) is not None}
    signals = {s: columns(value, kind if s == "command" else s) for s, value in found.items()}
    told = ", ".join(f"{joint} is taken to follow {mimic.joint}" for joint, mimic in led.items())
    return replace(
        recording,
        trace=replace(trace, joints=joints, **signals),  # type: ignore[arg-type]
        command=columns(recording.command, kind),
        notes=(*recording.notes, f"{told}, as the recording is without its own readings: {why}"),
    )
