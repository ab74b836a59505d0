"""Recordings that are taken as repetitions of one motion, and that differ as those of one machine do not.

The position error of a servo, and an effort, are as large as gains and loads make them. Noise, stick and slip, warmth
and the timing of a bus change them a little from one repetition to the next; another gain or another load changes them
by a share of their size.
"""

import json
from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np

from realitygap.check.mistake import Mistake
from realitygap.check.motion import MOVES, QUANTA, SLIDES
from realitygap.check.observed import Mask, Observed
from realitygap.check.words import wide
from realitygap.recording.align import RecordedRun, Repetitions, group_repetitions
from realitygap.recording.commands import held_at
from realitygap.recording.noise import own_noise
from realitygap.trace.trace import Array

DIFFER = 1 / 3
"""Two recordings differ by more than this share of the error or effort itself: 0.22 is the most of 240 repetitions of a
geared servo that sticks (sts3215_pendulum, 60 motions), and 57 of 60 differ by less than 0.1. A gain twice as large
makes 0.2 to 0.55, four times 0.33 to 1, and 2.8 kg on a UR10e's flange 0.68 of the effort of its wrist."""
HEARD = 5.0
"""And by more than this many standard deviations of the sensor's noise."""


def repetitions(observed: Sequence[Observed]) -> list[Repetitions]:
    """Which recordings a comparison takes as repetitions of one motion, as it groups them; those of two and more."""
    runs = [
        RecordedRun(o.name, o.recording, json.dumps(o.run.overrides, sort_keys=True), o.run.use, o.run.judged)
        for o in observed
    ]
    return [group for group in group_repetitions(runs) if len(group.indices) > 1]


def repetition_mistakes(observed: Sequence[Observed], told: Collection[str]) -> list[Mistake]:
    """Repetitions that differ as under other conditions, the plainest first; not by joints whose mistake is told.

    They stand at no joint: what repetitions differ by is their noise, beside which physics has to be seen anyway.
    """
    found: list[tuple[float, Mistake]] = []
    for group in repetitions(observed):
        runs = [observed[i] for i in group.indices]
        first, *others = runs  # beside the first one others are told apart, and a hundred of them take a moment
        shifts = group.shifts[1:]
        judged = np.array([joint not in told for joint in first.joints]) & _moving(first)
        apart = [_apart(first, o, shift, judged) for o, shift in zip(others, shifts, strict=True)]
        worst = max(apart, key=lambda a: a.share)
        if worst.share > DIFFER:
            sentence = (
                f"{len(runs)} recordings are taken as repetitions of one motion, and the {worst.signal} of "
                f"{worst.joint} in {worst.names[0]} and {worst.names[1]} differs by {worst.share:.0%} of its size: "
                "other gains or another load, as it seems; expected the same conditions: say by `with` at a run what "
                "differs (as {servos.*.gain: 2.5}, or robot.urdf with the load), or write a scenario each"
            )
            mistake = Mistake("other_conditions", "likely", (), sentence, first.key, (first.name,))
            found.append((worst.share, mistake))
    return [mistake for _, mistake in sorted(found, key=lambda f: -f[0])]


@dataclass(frozen=True)
class _Apart:
    """How far two recordings are apart at most: the share of which signal of which joint."""

    share: float
    signal: str = ""
    joint: str = ""
    names: tuple[str, str] = ("", "")


def _apart(a: Observed, b: Observed, late: float, judged: Mask) -> _Apart:
    """Where two repetitions differ most, the second `late` seconds later, of the joints (n,) that are judged.

    Of a position error that is known by the positions and by the commands, the smaller difference counts: commands that
    come a little otherwise are not the robot's.
    """
    first, second = a.recording.trace, b.recording.trace
    start, end = a.run.judged
    time = first.time[(first.time >= start) & (first.time <= end)]

    def both(signal: str) -> tuple[Array, Array] | None:
        x, y = getattr(first, signal), getattr(second, signal)
        return None if x is None or y is None else (_at(time, first.time, x), _at(time + late, second.time, y))

    worst = _Apart(0.0)
    position, effort = both("position"), both("effort")
    shares = []
    if position is not None:
        r, q = a.recording, b.recording
        if len(r.command_time) and len(q.command_time):
            x = held_at(r.command_time, r.command, time) - position[0]
            y = held_at(q.command_time, q.command, time + late) - position[1]
            share = np.minimum(_shares(x, y, size=(x, y)), _shares(*position, size=(x, y)))
            shares.append(("position error", np.where(a.follows & judged, share, 0.0)))
    if effort is not None:
        shares.append(("effort", np.where(judged, _shares(*effort, size=effort), 0.0)))
    for signal, share in shares:
        j = int(np.argmax(share))
        if share[j] > worst.share:
            worst = _Apart(float(share[j]), signal, a.joints[j], (a.name, b.name))
    return worst


def _shares(x: Array, y: Array, size: Sequence[Array]) -> Array:
    """The root mean square difference beyond noise, as a share of that of the size; 0 where it is not heard.

    Shapes (k, n) of all, gives (n,).
    """
    noise = np.hypot(own_noise(x), own_noise(y))
    apart, large = _rms(x - y), np.mean([_rms(s) for s in size], axis=0)
    beyond = np.sqrt(np.maximum(apart**2 - noise**2, 0.0))
    return np.asarray(np.where((apart > HEARD * noise) & (large > 0), beyond / np.maximum(large, 1e-300), 0.0))


def _rms(value: Array) -> Array:
    """The root mean square of what is known. Shape (k, n), gives (n,); 0 where nothing is."""
    known = np.isfinite(value)
    return np.asarray(np.sqrt((np.where(known, value, 0.0) ** 2).sum(axis=0) / np.maximum(known.sum(axis=0), 1)))


def _moving(o: Observed) -> Mask:
    """The joints that move: of one at rest, friction holds position and effort anywhere within its bounds."""
    least = np.array([SLIDES if o.prismatic(j) else MOVES for j in range(len(o.joints))])
    return np.asarray(wide(o.position) > np.maximum(least, QUANTA * o.quantum))


def _at(time: Array, own: Array, value: Array) -> Array:
    """A signal at other times, linear between samples, NaN outside them and beside what is unknown. Shape (k, n)."""
    return np.column_stack([np.interp(time, own, column, left=np.nan, right=np.nan) for column in value.T])
