"""Readings that stand apart from all others of a joint: placeholders of what was lost, or those of a second sender."""

import numpy as np

from realitygap.check.mistake import Mistake
from realitygap.check.observed import Mask, Observed
from realitygap.check.reading import FEWEST, JUMP_QUANTA
from realitygap.check.words import unit
from realitygap.recording.commands import held_at
from realitygap.trace.trace import Array

APART = 10.0
"""How many times the range of all other readings placeholders are away from them."""
TURNS, TURNS_SLIDE = 4.0 * np.pi, 10.0
"""rad and m: so far away they are at least, since a joint that rests has no range."""
AWAY = 10.0
"""How many times further from the readings around it a second sender's is than these from one another."""
JUMP, JUMP_SLIDE = 0.02, 0.002
"""rad (1°) and m: jumps at least, beside quanta, which do not show where something smooth was added to a reading."""
SHARE = 0.02
"""Of the readings, at least: of white noise, one in a thousand looks like that."""


def stray_readings(o: Observed) -> list[Mistake]:
    """Positions that no motion leads to and that are more than a few that were garbled."""
    position = o.recording.trace.position
    if position is None:
        return []
    return [m for j in range(len(o.joints)) for m in (_placeholders(o, j, position[:, j]) or _second(o, j))]


def _placeholders(o: Observed, j: int, value: Array) -> list[Mistake]:
    """The fewer readings of a joint (t,) beyond the widest gap in its values, where no motion is as far from it."""
    known = np.sort(value[np.isfinite(value)])
    if len(known) < FEWEST:
        return []
    gaps = np.diff(known)
    widest = int(np.argmax(gaps))
    below, above = known[: widest + 1], known[widest + 1 :]
    few, rest = (below, above) if len(below) < len(above) else (above, below)
    if gaps[widest] <= max(APART * np.ptp(rest), TURNS_SLIDE if o.prismatic(j) else TURNS):
        return []
    said = f"is {few[0]:.6g}" if few[0] == few[-1] else f"lies from {few[0]:.6g} to {few[-1]:.6g}"
    rad, count = unit(o, j), len(few)
    sentence = (
        f"the position of {o.joints[j]} {said} {rad} in {count} reading{'s' * (count > 1)}, and from {rest[0]:.3g} to "
        f"{rest[-1]:.3g} {rad} in the other {len(rest)}: placeholders of readings that were lost; expected what was "
        "measured, or no reading (an empty cell) where nothing was: take them out"
    )
    return [Mistake("placeholder", "certain", (o.joints[j],), sentence, o.line("position"), (o.name,))]


def _second(o: Observed, j: int) -> list[Mistake]:
    """Readings that jump away from those around them and back, again and again, and not as commanded."""
    trace = o.recording.trace
    assert trace.position is not None
    value = trace.position[:, j]
    if len(value) < FEWEST:
        return []
    jumps = _away(value)
    if o.follows[j]:
        asked = _away(held_at(o.recording.command_time, o.recording.command[:, j], trace.time))
        jumps[asked > 0.0] = 0.0
    away: Mask = jumps > max(JUMP_QUANTA * o.quantum[j], JUMP_SLIDE if o.prismatic(j) else JUMP)
    count = int(away.sum())
    if count < max(FEWEST, SHARE * len(value)):
        return []
    sentence = (
        f"{count} of {len(value)} readings of {o.joints[j]} are away from those before and after them, which agree, by "
        f"{np.median(jumps[away]):.3g} {unit(o, j)} and more often than a bus garbles one: two senders of one joint, "
        "as a joint_state_publisher beside the robot's driver; expected readings of one: record with one sender, or "
        "take the other's out"
    )
    return [Mistake("two_senders", "likely", (o.joints[j],), sentence, o.line("position"), (o.name,))]


def _away(value: Array) -> Array:
    """How far every inner reading jumps away from its neighbours and back; 0 where it does not. Shape (t,) gives
    (t - 4,).

    Further out a reading is like the neighbours, or like the one between them where two senders take turns: a
    triangle's peak is neither.
    """
    first, before, at, after, last = (value[k : len(value) - 4 + k] for k in range(5))
    jump = np.minimum(np.abs(at - before), np.abs(at - after))
    with np.errstate(invalid="ignore"):
        alike = np.abs(after - before) <= jump / AWAY
        for outer, near in ((first, before), (last, after)):
            alike &= np.minimum(np.abs(outer - near), np.abs(outer - at)) <= jump / AWAY
    return np.where(alike, jump, 0.0)
