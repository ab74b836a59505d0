"""From streams on their own clocks to one recording on the clock of the joint states."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from realitygap.files.errors import InputError
from realitygap.recording.absent import holes, without_absent
from realitygap.recording.command_turns import command_without_turns
from realitygap.recording.commands import held_at, in_force, usual_period
from realitygap.recording.delay import Mask
from realitygap.recording.frames import unit_quaternions
from realitygap.recording.lack import Lack
from realitygap.recording.merged import on_one_clock
from realitygap.recording.outliers import told, without_outliers
from realitygap.recording.recording import Recording
from realitygap.recording.streams import COMMAND_SIGNAL, Request, Samples, Streams
from realitygap.recording.turns import (
    NO_LIMITS,
    told_limits,
    told_pauses,
    told_turns,
    within_limits,
    without_turns,
)
from realitygap.trace.trace import Array, Trace

JUMP = 60.0
"""s: a pause that is longer, and longer than all the rest, is no pause."""
ITSELF = "the measured effort drives the motion: it is not compared with itself, and what it is off by is a gain"
CLOSEST = 1e-7
"""s: samples of one stream are further apart on any bus; times of another unit are told by `check`."""


def assemble(path: Path, streams: Streams, request: Request) -> Recording:
    """One recording: time starts at the first message, other streams are brought to the clock of the joint states.

    Raises:
        InputError: for a value that is infinite, a stream of which too little was measured, or a signal that the
            scenario asks for and that was not recorded.
    """
    zero = min(float(s.time[0]) for s in streams.all())
    limits = np.array([request.limits.get(joint, NO_LIMITS) for joint in request.joints]).reshape(-1, 2)
    streams, wraps, counted = _counted(_from(zero, streams), limits)
    streams, merged = _merged(streams)
    clock = streams.state or streams.pose
    if clock is None:
        raise InputError(f"{request.file}: recordings: neither joint states nor a base pose are asked of {path}")
    if len(clock.time) < 2:
        raise InputError(f"{clock.source}: holds {len(clock.time)} sample, expected at least two")
    for samples in streams.all():
        _steady(samples)
    pauses = holes(clock.time)
    streams, absent = _known(streams)
    clock = streams.state or streams.pose
    assert clock is not None
    signals = _joint_signals(streams, request, clock)
    signals |= _body_signals(streams, clock.time)
    lacking = [*streams.dropped, *counted, *pauses, *absent]
    notes = [*streams.notes, *merged]
    command_time, command, kind = np.empty(0), np.empty((0, len(request.joints))), None
    if streams.command is not None:
        kind = request.motion.meaning if request.motion is not None else "position"
        command_time, command, found = _command(streams.command, kind, clock.time)
        if request.command_factor is not None:
            command = command * request.command_factor
            if signals.pop("effort", None) is not None:
                notes.append(ITSELF)
        if kind == "position":
            measured = Trace(clock.time, request.joints, position=signals["position"])
            command, taken = command_without_turns(command_time, command, measured, wraps, limits)
            lacking += told_turns(request.joints, "command", taken)
        signals["command"] = held_at(command_time, command, clock.time)
        notes += found
    supply_time, supply = np.empty(0), np.empty(0)
    if streams.supply is not None:
        supply_time, supply = streams.supply.time, streams.supply.signals["supply"]
        signals["supply"] = np.interp(clock.time, supply_time, supply)
    if streams.temperature is not None:
        signals["temperature"] = _temperature(streams.temperature, request, clock.time)
    trace, outliers = without_outliers(replace(Trace(clock.time, request.joints), **signals))  # type: ignore[arg-type]
    notes += [*(lack.text for lack in lacking), *told(outliers).values()]
    return Recording(
        path,
        trace,
        command_time,
        command,
        kind,
        supply_time,
        supply,
        clock.receive,
        tuple(dict.fromkeys(notes)),
        outliers,
        streams.episode,
        streams.files,
        tuple(lacking),
        streams.dated,
    )


def _from(zero: float, streams: Streams) -> Streams:
    def moved(samples: Samples | None) -> Samples | None:
        if samples is None:
            return None
        receive = None if samples.receive is None else samples.receive - zero
        return replace(samples, time=samples.time - zero, receive=receive)

    return replace(
        streams,
        state=moved(streams.state),
        command=moved(streams.command),
        effort=moved(streams.effort),
        pose=moved(streams.pose),
        imu=moved(streams.imu),
        supply=moved(streams.supply),
        temperature=moved(streams.temperature),
    )


def _counted(streams: Streams, limits: Array) -> tuple[Streams, Mask, list[Lack]]:
    """The streams with the turns of encoders counted, from one within the joints' limits (n, 2) on; which joints had
    such turns (n,), and what is told of it.
    """
    state = streams.state
    if state is None or "position" not in state.signals:
        return streams, np.zeros(len(limits), dtype=bool), []
    position, turned, unknown = without_turns(state.time, state.signals["position"])
    position, moved = within_limits(position, limits)
    told = [
        *told_turns(state.joints, "position", turned),
        *told_pauses(state.joints, unknown),
        *told_limits(state.joints, moved, limits),
    ]
    state = replace(state, signals={**state.signals, "position": position})
    return replace(streams, state=state), np.array([len(at) > 0 for at in turned], dtype=bool) | (moved != 0), told


def _merged(streams: Streams) -> tuple[Streams, list[str]]:
    """The streams with all joints in every sample of what was measured, and what is told of it."""
    known: dict[str, Samples] = {}
    told = []
    for name in ("state", "effort"):
        samples: Samples | None = getattr(streams, name)
        if samples is not None:
            known[name], note = on_one_clock(samples)
            told += [note] if note else []
    return replace(streams, **known), told  # type: ignore[arg-type]


def _known(streams: Streams) -> tuple[Streams, list[Lack]]:
    """The streams without samples of which something is absent that is needed, and what is told of it.

    A state needs its positions, an effort of its own nothing; all else is of use as a whole only. A command that is
    absent is none.
    """
    known: dict[str, Samples] = {}
    notes = []
    for name in ("state", "effort", "pose", "imu", "supply", "temperature"):
        samples: Samples | None = getattr(streams, name)
        if samples is not None:
            needed = {"state": ("position",), "effort": ()}.get(name, tuple(samples.signals))
            known[name], told = without_absent(samples, needed)
            notes += told
    return replace(streams, **known), notes  # type: ignore[arg-type]


def _joint_signals(streams: Streams, request: Request, clock: Samples) -> dict[str, Array]:
    if not request.joints:
        return {"position": np.empty((len(clock.time), 0))}
    state = streams.state
    assert state is not None
    if "position" not in state.signals:
        raise InputError(f"{state.source}: holds no joint positions; expected the measured joint states")
    signals = {name: value for name, value in state.signals.items() if name != "effort"}
    factor = request.effort_factor
    if factor is not None:
        source = state if streams.effort is None else streams.effort
        if "effort" not in source.signals:
            raise InputError(
                f"{request.file}: recordings.effort: {source.source} holds no effort; expected `effort: none`, or "
                "{topic: NAME} of the stream or column that holds it"
            )
        effort = _at(source.time, source.signals["effort"], clock.time)
        signals["effort"] = effort if (factor == 1.0).all() else factor * effort
    return signals


def _temperature(samples: Samples, request: Request, time: Array) -> Array:
    """Of every joint's motor at other times; a sensor for all of them tells the same of each. Shape (t, n)."""
    value = samples.signals["temperature"].reshape(len(samples.time), -1)
    near = np.column_stack([np.interp(time, samples.time, column) for column in value.T])
    return np.asarray(np.broadcast_to(near, (len(time), len(request.joints))))


def _body_signals(streams: Streams, time: Array) -> dict[str, Array]:
    """Base and IMU signals at other times; orientations are put back on the unit sphere after interpolation."""
    signals = {}
    for samples in (s for s in (streams.pose, streams.imu) if s is not None):
        for name, value in samples.signals.items():
            if not name.endswith("quaternion"):
                signals[name] = _at(samples.time, value, time)
                continue
            unit = unit_quaternions(value)
            if np.isnan(unit).any():
                raise InputError(f"{samples.source}: an orientation is all zeros, expected a unit quaternion")
            signals[name] = unit_quaternions(_at(samples.time, unit, time))
    return signals


def _at(own: Array, value: Array, time: Array) -> Array:
    """A signal interpolated linearly; NaN where its stream has not begun or is over (by more than two periods)."""
    if np.array_equal(own, time):
        return value
    out = np.column_stack([np.interp(time, own, column) for column in value.T])
    margin = 2.0 * (usual_period(own) or 0.0)
    out[(time < own[0] - margin) | (time > own[-1] + margin)] = np.nan
    return np.asarray(out)


def _command(samples: Samples, kind: str, state_time: Array) -> tuple[Array, Array, list[str]]:
    name = COMMAND_SIGNAL[kind]
    if name not in samples.signals:
        found = " and ".join(samples.signals) or "nothing"
        raise InputError(f"{samples.source}: holds {found}, expected {name}, as the motion's commands are `as: {kind}`")
    value = samples.signals[name]
    if np.isinf(value).any():
        raise InputError(f"{samples.source}: a command is infinite, expected finite numbers (or NaN for none)")
    return in_force(samples.time, value, samples.present, state_time, samples.joints)


def _steady(samples: Samples) -> None:
    """Make sure that a clock went on: no pause longer than all the rest of a recording and than `JUMP`, and no samples
    as close to one another as no bus brings them.
    """
    steps = np.diff(samples.time)
    if not len(steps):
        return
    longest = int(np.argmax(steps))
    rest = float(samples.time[-1] - samples.time[0] - steps[longest])
    if steps[longest] > max(JUMP, rest):
        raise InputError(
            f"{samples.source}: the clock jumps from {samples.time[longest]:.3f} to {samples.time[longest + 1]:.3f} s, "
            f"which is longer than all the rest ({rest:.3g} s); expected a clock without jumps: cut the recording there"
        )
    spacing = float(np.median(steps))
    if spacing < CLOSEST:
        raise InputError(
            f"{samples.source}: the samples are {spacing:.3g} s apart, as those of no bus; expected times in seconds, "
            "stamped by a clock that runs"
        )
