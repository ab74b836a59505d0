"""Repetitions of one motion: which runs are, how far apart their clocks are, and how much they differ."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import takewhile
from typing import Protocol

import numpy as np

from realitygap.recording.commands import held_at
from realitygap.recording.delay import MOVING, Mask, command_difference, command_range, delay, moving_commands
from realitygap.recording.frames import angle_between, unit_quaternions, vertical
from realitygap.recording.quantum import quantum
from realitygap.recording.recording import Recording
from realitygap.trace.trace import Array, Trace

SAME_COMMAND = 0.05  # largest difference of commands of one motion, as a share of their standard deviation
SAME_MOVE = 0.1  # the same of measured positions where nothing was commanded: what swings freely repeats less exactly
STILL = 4.0  # steps of a command within which it stays where nothing is asked for
SAME_ANGLE = np.radians(2.0)  # rad: largest difference at the start of bodies that nothing drives
SAME_PLACE = 0.01  # m, likewise


class Windowed(Protocol):
    """A run of a scenario: what was recorded, and under which conditions."""

    @property
    def name(self) -> str: ...
    @property
    def recording(self) -> Recording | None: ...
    @property
    def overrides(self) -> str: ...
    @property
    def use(self) -> str | None: ...
    @property
    def window(self) -> tuple[float, float]: ...


@dataclass(frozen=True)
class RecordedRun:
    """A run that is nothing but recorded."""

    name: str
    recording: Recording
    overrides: str = "{}"
    use: str | None = None
    window: tuple[float, float] = (-np.inf, np.inf)


@dataclass(frozen=True)
class Repetitions:
    """Runs that repeat one motion under the same conditions.

    Attributes:
        name: what the runs' names have in common.
        indices: which runs.
        shifts: what to add to the first one's clock to get each one's [s].
    """

    name: str
    indices: tuple[int, ...]
    shifts: tuple[float, ...]


def group_repetitions(runs: Sequence[Windowed]) -> list[Repetitions]:
    """The runs as motions, in the order given: those of one motion under the same conditions together.

    The same conditions are the same overrides and the same use; the same window of one file twice is not a repetition.
    """
    groups: list[list[tuple[int, float]]] = []
    for i, run in enumerate(runs):
        for group in groups:
            shift = _shift(runs[group[0][0]], run)
            if shift is not None and all(_path(runs[k]) != _path(run) for k, _ in group):
                group.append((i, shift))
                break
        else:
            groups.append([(i, 0.0)])
    out = []
    for group in groups:
        indices, shifts = zip(*group, strict=True)
        out.append(Repetitions(_common_name([runs[i].name for i in indices]), indices, shifts))
    return out


def _path(run: Windowed) -> object:
    return None if run.recording is None else run.recording.source


def _shift(first: Windowed, run: Windowed) -> float | None:
    """How much later the motion is on a run's clock [s]; None where it is another motion or other conditions."""
    a, b = first.recording, run.recording
    if a is None or b is None or (first.overrides, first.use) != (run.overrides, run.use):
        return None
    if a.trace.joints != b.trace.joints or a.command_kind != b.command_kind:
        return None
    if _told(a) != _told(b):
        return None
    ways = [(a, b)] if _told(a) else [(_led(a), _led(b)), *([(a, b)] if _free(a) and _free(b) else [])]
    for one, other in ways:
        late = delay(one, other)
        if _same_window(first.window, run.window, late) and same_motion(one, other, late):
            return late
    return None


def _same_window(first: tuple[float, float], other: tuple[float, float], late: float) -> bool:
    """Whether two windows are the same part of a motion that comes `late` seconds later on the other clock."""
    length = min(first[1] - first[0], other[1] - other[0])
    return first == other or abs(first[0] + late - other[0]) <= 0.1 * length


def _free(recording: Recording) -> bool:
    """Whether nothing brought its joints to a place: efforts were told, or servos were off, so that a motion may forget
    how it began.
    """
    return recording.command_kind in ("effort", "duty") or (
        recording.command_kind is not None and not np.isfinite(recording.command).any()
    )


def _told(recording: Recording) -> bool:
    """Whether its commands say what it did, as those of a hold, of a free swing or of none do not."""
    return recording.command_kind is not None and bool((moving_commands(recording) | _stirring(recording)).any())


def _stirring(recording: Recording) -> Mask:
    """Which joints are commanded over more than a few of the command's own steps, however small. Shape (n,)."""
    return np.asarray(command_range(recording) > STILL * quantum(recording.command))


def _led(recording: Recording) -> Recording:
    """A recording as if it had been led along where its joints were measured, where nothing else says what led them."""
    trace = recording.trace
    if _told(recording) or trace.position is None or not trace.joints:
        return recording
    return replace(recording, command_time=trace.time, command=trace.position, command_kind=None)


def same_motion(reference: Recording, other: Recording, late: float) -> bool:
    """Whether two runs are one motion, the other one `late` seconds later on its clock.

    Their commands agree within 5 % of their standard deviation over at least nine tenths of the shorter run; where
    nothing was commanded, their measured positions within 10 %, in which joints that nothing holds start alike, too.
    Bodies without joints start alike (2°, 10 mm) and are recorded equally long within a tenth.
    """
    a, b = reference.trace, other.trace
    lengths = a.time[-1] - a.time[0], b.time[-1] - b.time[0]
    if not reference.command.size:
        return min(lengths) >= 0.9 * max(lengths) and _start_alike(a, b)
    moving = moving_commands(reference) | moving_commands(other)
    start, end = max(a.time[0], b.time[0] - late), min(a.time[-1], b.time[-1] - late)
    if end - start < 0.9 * min(lengths):
        return False
    time = a.time[(a.time >= start) & (a.time <= end)]
    if not len(time):  # of a few samples, none may be at a time that both have
        return False
    x = held_at(reference.command_time, reference.command, time)
    y = held_at(other.command_time, other.command, time + late)
    if np.mean(np.isnan(x) != np.isnan(y)) > 0.02:  # the servos are off at other times
        return False
    if _free(reference) and not _start_near(a, b, start, late):
        return False
    if not moving.any() and reference.command_kind is not None:
        moving = _stirring(reference) | _stirring(other)
    if not moving.any():
        return bool(np.nanmax(np.abs(x - y), initial=0.0) < MOVING)
    spread = float(np.sqrt(np.nanvar(reference.command[:, moving], axis=0).mean()))
    share = SAME_MOVE if reference.command_kind is None else SAME_COMMAND
    return bool(np.sqrt(command_difference(reference, other, moving, late)) <= share * spread)


def _start_near(a: Trace, b: Trace, start: float, late: float) -> bool:
    """Whether joints that nothing brings to a place were at the same one, in the spread of where they went."""
    if a.position is None or b.position is None:
        return True
    one, other = held_at(a.time, a.position, np.array([start])), held_at(b.time, b.position, np.array([start + late]))
    seen = np.isfinite(a.position).any(axis=0)
    spread = np.sqrt(np.nanvar(a.position[:, seen], axis=0).mean()) if seen.any() else np.inf
    return bool(np.nanmax(np.abs(one - other), initial=0.0) <= SAME_MOVE * spread)


def _start_alike(a: Trace, b: Trace) -> bool:
    if a.base_position is None or b.base_position is None or a.base_quaternion is None or b.base_quaternion is None:
        return False
    near = np.linalg.norm(a.base_position[0] - b.base_position[0]) <= SAME_PLACE
    return bool(near and angle_between(a.base_quaternion[:1], b.base_quaternion[:1])[0] <= SAME_ANGLE)


def _common_name(names: list[str]) -> str:
    """The leading words that all names share: sine_rep1 and sine_rep2 are sine."""
    if len(names) == 1:
        return names[0]
    words = [re.findall(r"[^_#-]+[_#-]*", name) for name in names]
    stripped = [[word.rstrip("_#-") for word in each] for each in words]
    count = sum(1 for _ in takewhile(lambda column: len(set(column)) == 1, zip(*stripped, strict=False)))
    return "".join(words[0][:count]).rstrip("_#-") or names[0]


def noise_floor(traces: Sequence[Trace]) -> dict[tuple[str, str], float]:
    """How much repetitions of one motion differ, by joint (or "base") and signal, in SI.

    The mean absolute difference of one repetition from the mean of the others, over all of them. A single run gives a
    quarter of the sensor's quantum: a rounding error is uniform within half a quantum to either side, and its mean
    absolute value, which is what a gap is, is a quarter of the quantum (its root mean square would be 1/√12 of it).

    Args:
        traces: repetitions of one motion on one clock, or a single one.
    """
    joints = traces[0].joints
    floors: dict[tuple[str, str], float] = {}
    for signal in ("position", "velocity", "effort"):
        values = [v for t in traces if (v := getattr(t, signal)) is not None]
        if len(values) < len(traces):
            continue
        floor = quantum(values[0]) / 4.0 if len(traces) == 1 else _mean_over_time(np.abs(_from_others(values)))
        floors |= {(joint, signal): float(f) for joint, f in zip(joints, floor, strict=True) if np.isfinite(f)}
    if len(traces) > 1:
        floors |= {("base", signal): value for signal, value in _base_floors(traces).items()}
    return floors


def _base_floors(traces: Sequence[Trace]) -> dict[str, float]:
    """The same for the base: distance [m], angle [rad] (of the vertical, by an IMU) and angular velocity [rad/s]."""

    def all_of(signal: str) -> list[Array]:
        values = [v for t in traces if (v := getattr(t, signal)) is not None]
        return values if len(values) == len(traces) else []

    found: dict[str, Array] = {}
    if position := all_of("base_position"):
        found["base_position"] = np.linalg.norm(_from_others(position), axis=2)
    if quaternion := all_of("base_quaternion"):
        signed = [q * np.where(np.sum(q * quaternion[0], axis=1, keepdims=True) < 0, -1.0, 1.0) for q in quaternion]
        means = np.array(signed) - _from_others(signed)
        angles = [angle_between(q, unit_quaternions(m)) for q, m in zip(signed, means, strict=True)]
        found["base_orientation"] = np.array(angles)
    elif quaternion := all_of("imu_quaternion"):
        found["base_orientation"] = np.linalg.norm(_from_others([vertical(q) for q in quaternion]), axis=2)
    if angular := all_of("base_angular"):
        found["base_angular_velocity"] = np.linalg.norm(_from_others(angular), axis=2)
    elif angular := all_of("imu_angular"):
        found["base_angular_velocity"] = np.abs(_from_others([np.linalg.norm(w, axis=1) for w in angular]))
    return {signal: float(np.nanmean(value)) for signal, value in found.items() if np.isfinite(value).any()}


def _from_others(values: Sequence[Array]) -> Array:
    """Each repetition's difference from the mean of the others. Shapes r × (t, ...), gives (r, t, ...)."""
    stacked = np.array(values)
    count = len(stacked)
    return np.asarray((stacked - stacked.mean(axis=0)) * count / (count - 1))


def _mean_over_time(value: Array) -> Array:
    """The mean over repetitions and time of what is known. Shape (r, t, n), gives (n,); NaN where nothing is."""
    known = np.isfinite(value)
    count = known.sum(axis=(0, 1))
    return np.asarray(np.where(count > 0, np.where(known, value, 0.0).sum(axis=(0, 1)) / np.maximum(count, 1), np.nan))
