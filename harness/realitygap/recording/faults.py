"""What is wrong with a recording itself: faults of sensors and clocks, told before physics is blamed for them."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from realitygap.files.found import counted
from realitygap.recording.delay import delay, moving_commands
from realitygap.recording.noise import beyond_noise, own_noise
from realitygap.recording.outliers import told
from realitygap.recording.quantum import quantum
from realitygap.recording.recording import Recording
from realitygap.trace.first_order import first_order
from realitygap.trace.trace import Array

STRETCH = 0.15  # s: over which the travel by velocity and by position are compared
TIMES = np.linspace(0.0, 0.1, 51)  # s: low-pass filters that are tried
SURE = 0.9  # correlation of travel by velocity with travel by position from which on a filter is believed
OFF = 0.04  # a scale of a velocity further than this from 1 is a fault
CHANCE = 5.0  # standard deviations: of a million steps that noise alone moves, none
CLOCK_DRIFT = 100e-6  # quartz clocks drift by 20 to 50 millionths


@dataclass(frozen=True)
class Fault:
    """A fault of a recording: its kind, the joints it was seen at ("" for all), one sentence, and its numbers."""

    kind: str
    joints: tuple[str, ...]
    sentence: str
    numbers: dict[str, float] = field(default_factory=dict)


def faults(recording: Recording) -> list[Fault]:
    """Every fault that is seen in one recording."""
    found = [*velocity_faults(recording), *command_glitches(recording), repeated_readings(recording)]
    found.append(clock_drift(recording))
    found += [Fault("outlier", (joint,), sentence) for (joint, _), sentence in told(recording.outliers).items()]
    return [fault for fault in found if fault is not None]


def velocity_faults(recording: Recording) -> list[Fault]:
    """Reported velocities that are not the derivative of position, but scaled or low-passed.

    A first-order filter of time constant τ and a scale a make v = a·LP(q̇), so that the travel by velocity over a
    stretch of time is a·(LP(q) at its end - LP(q) at its start). Travel, unlike a derivative, does not amplify the
    quantum of the encoder.
    """
    trace = recording.trace
    if trace.position is None or trace.velocity is None:
        return []
    period = float(np.median(np.diff(trace.time)))
    fits = {}
    for i, joint in enumerate(trace.joints):
        fit = velocity_of_position(trace.time, trace.position[:, i], trace.velocity[:, i])
        if fit is not None and at_fault(*fit, period):
            fits[joint] = fit
    if not fits:
        return []
    scale, time = (float(np.median([fit[k] for fit in fits.values()])) for k in (0, 1))
    who = next(iter(fits)) if len(fits) == 1 else f"{len(fits)} of {len(trace.joints)} joints"
    late = f", low-passed with {1e3 * time:.0f} ms" if 1e3 * time > 0.5 else ""
    sentence = (
        f"the reported velocity of {who} is {scale:.3f} times the derivative of the position{late}"
        f"{' (medians)' * (len(fits) > 1)}: the sensor, not the robot"
    )
    return [Fault("velocity", tuple(fits), sentence, {"scale": scale, "time": time})]


def at_fault(scale: float, constant: float, correlation: float, period: float) -> bool:
    """Whether a filter of a velocity is one of the sensor: seen for sure, and more than a plain difference of positions
    does, which is the mean over the last period and so late by half of it [s].
    """
    return abs(correlation) > SURE and (abs(scale - 1.0) > OFF or constant > 0.5 * period + TIMES[1])


def velocity_of_position(time: Array, position: Array, velocity: Array) -> tuple[float, float, float] | None:
    """Scale and low-pass time constant [s] that make a reported velocity of a position, and the correlation of travel.

    All Shape (t,), the velocity NaN where it is unknown. None where the joint moves too little to tell: less than 20
    quanta within 0.15 s, or than its own noise.
    """
    known = np.isfinite(velocity)
    if known.sum() < 2:
        return None
    time, position, velocity = time[known], position[known], velocity[known]
    even = np.arange(time[0], time[-1], float(np.median(np.diff(time))))
    if len(even) < 2:
        return None
    q = np.interp(even, time, position)
    v = np.interp(even, time, velocity)
    span = max(1, round(STRETCH / float(even[1] - even[0])))
    travel: Array = float(even[1] - even[0]) * np.append(0.0, np.cumsum(0.5 * (v[1:] + v[:-1])))
    by_velocity, by_position = travel[span:] - travel[:-span], q[span:] - q[:-span]
    step = float(quantum(position[:, None])[0])
    if np.abs(by_position).max(initial=0.0) <= 20.0 * step or not by_velocity.any():
        return None
    if not beyond_noise(by_position[:, None], position[:, None])[0]:
        return None
    period = float(even[1] - even[0])

    def travelled(constant: float) -> tuple[Array, float]:
        smooth = low_pass(q, constant, period)
        by_position = smooth[span:] - smooth[:-span]
        return by_position, float(by_velocity @ by_position / (by_position @ by_position))

    errors = []
    for tried in TIMES:
        by_position, scale = travelled(tried)
        errors.append(float(np.sum((by_velocity - scale * by_position) ** 2)))
    best = int(np.argmin(errors))
    constant = float(TIMES[best])
    if 0 < best < len(TIMES) - 1:  # the lowest point of the parabola through the best three
        before, here, after = errors[best - 1 : best + 2]
        if before + after > 2.0 * here:
            constant += 0.5 * float(TIMES[1]) * (before - after) / (before - 2.0 * here + after)
    by_position, scale = travelled(constant)
    return scale, constant, float(np.corrcoef(by_velocity, by_position)[0, 1])


def low_pass(value: Array, constant: float, period: float) -> Array:
    """A first-order low-pass of time constant `constant` [s], exact for input that is linear between samples."""
    if constant < 1e-9:
        return value
    decay = float(np.exp(-period / constant))
    lead = constant / period * (1.0 - decay)
    driven = (1.0 - lead) * value[1:] + (lead - decay) * value[:-1]
    return np.concatenate([value[:1], first_order(driven, decay, float(value[0]))])


def repeated_readings(recording: Recording) -> Fault | None:
    """Readings of a joint that repeat the one before them, in position and velocity, in the middle of a motion.

    In the middle means that the position moves the same way by two quanta or more just before and just after, and so
    far that noise does not make it stand still: `CHANCE` standard deviations of what a step differs by from the mean of
    its neighbours, which is half a third difference.
    """
    trace = recording.trace
    if trace.position is None or not len(trace.joints) or len(trace.time) < 4:
        return None
    steps = np.diff(trace.position, axis=0)
    one = quantum(trace.position)
    before, at, after = steps[:-2], steps[1:-1], steps[2:]
    moves = (np.abs(before) > 1.9 * one) & (np.abs(after) > 1.9 * one) & (before * after > 0) & (one > 0)
    middle = 0.5 * (before + after)
    moves &= np.abs(middle) > CHANCE * np.sqrt(5.0) * own_noise(trace.position)
    repeated = moves & (at == 0)
    if trace.velocity is not None:
        repeated &= np.diff(trace.velocity, axis=0)[1:-1] == 0
    if not repeated.any():
        return None
    count, moving = int(repeated.sum()), int(moves.sum())
    joints = tuple(name for name, seen in zip(trace.joints, repeated.any(axis=0), strict=True) if seen)
    sentence = (
        f"{count} of {moving} reading{'s' * (moving > 1)} in motion "
        f"{'repeat the one before them' if count > 1 else 'repeats the one before it'}, in {', '.join(joints)}: "
        "the bus, not the robot"
    )
    return Fault("repeated", joints, sentence, {"count": count, "share": count / moving})


def command_glitches(recording: Recording) -> list[Fault]:
    """Single commands that jump away and back: more than 2° and five times what the commands around them differ.

    Of positions: a controller that asks for efforts or speeds answers noise, and jumps as it is meant to.
    """
    command = recording.command
    if recording.command_kind != "position" or len(command) < 5:
        return []
    before, at, after = command[:-2], command[1:-1], command[2:]
    steps = np.pad(np.abs(np.diff(command, axis=0)), ((1, 1), (0, 0)))
    usual = np.fmax(np.abs(after - before), np.maximum(steps[:-3], steps[3:]))  # a fast sine turns at a sharp peak
    jump = np.minimum(np.abs(at - before), np.abs(at - after))
    back = (at - before) * (at - after) > 0
    with np.errstate(invalid="ignore"):
        glitch = back & (jump > np.radians(2.0)) & (jump > 5.0 * usual)
    faults = []
    for row in np.flatnonzero(glitch.any(axis=1)):
        columns = np.flatnonzero(glitch[row])
        joints = tuple(recording.trace.joints[i] for i in columns)
        size, time = float(jump[row, columns].max()), float(recording.command_time[row + 1])
        sentence = (
            f"one command at {time:.3f} s jumps away by up to {np.degrees(size):.1f}° and back in "
            f"{counted(len(joints), 'joint')} ({', '.join(joints)}): a glitch of the sender, which the servos got"
        )
        faults.append(Fault("command glitch", joints, sentence, {"time": time, "size": size}))
    return faults


def clock_drift(recording: Recording) -> Fault | None:
    """Header stamps that run faster or slower than the recorder's clock by more than 100 millionths."""
    if recording.receive_time is None:
        return None
    return _drift(recording.trace.time, recording.receive_time, "the header stamps run", "the recorder's clock")


def drift_between(reference: Recording, other: Recording) -> Fault | None:
    """Clocks of two repetitions that run apart: the delay of the command in the first and the last third."""
    if not (moving_commands(reference) & moving_commands(other)).any():
        return None
    whole = delay(reference, other)
    start, end = reference.trace.time[0], reference.trace.time[-1]
    third = (end - start) / 3.0
    late = []
    for a, b in ((start, start + third), (end - third, end)):
        parts = [_part(reference, a, b), _part(other, a + whole - 0.1 * third, b + whole + 0.1 * third)]
        if any(len(p.command) < 10 for p in parts) or not (moving_commands(parts[0]) & moving_commands(parts[1])).any():
            return None
        late.append(delay(parts[0], parts[1]))
    rate = (late[1] - late[0]) / (2.0 * third)
    if abs(rate) <= CLOCK_DRIFT or abs(late[1] - late[0]) < 0.5 * float(np.median(np.diff(reference.command_time))):
        return None
    sentence = (
        f"the clock of {other.name} runs {abs(rate):.2%} {'slower' if rate < 0 else 'faster'} than that of "
        f"{reference.name}: {1e3 * abs(late[1] - late[0]):.0f} ms between the first and the last third"
    )
    return Fault("clock drift", (), sentence, {"rate": rate})


def _part(recording: Recording, start: float, end: float) -> Recording:
    inside: NDArray[np.bool_] = (recording.command_time >= start) & (recording.command_time <= end)
    return Recording(
        recording.path,
        recording.trace.between(start, end),
        recording.command_time[inside],
        recording.command[inside],
        recording.command_kind,
        recording.supply_time,
        recording.supply,
    )


def _drift(time: Array, receive: Array, who: str, whom: str) -> Fault | None:
    """A trend of the time between stamp and reception, of the earliest in each tenth: queues only make later."""
    late = receive - time
    tenths = [part for part in np.array_split(np.arange(len(time)), 10) if len(part)]
    if len(tenths) < 10:
        return None
    earliest = np.array([part[np.argmin(late[part])] for part in tenths])
    rate = float(np.polyfit(time[earliest], late[earliest], 1)[0])
    total = abs(rate) * float(time[-1] - time[0])
    if abs(rate) <= CLOCK_DRIFT or total < 0.5 * float(np.median(np.diff(time))):
        return None
    pace = "slower" if rate > 0 else "faster"
    sentence = f"{who} {abs(rate):.2%} {pace} than {whom}: {1e3 * total:.0f} ms over the recording"
    return Fault("clock drift", (), sentence, {"rate": rate})
