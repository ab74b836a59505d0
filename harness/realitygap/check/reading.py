"""Readings of a joint's position that stand still while it moves, or stand beside the command all along."""

from collections.abc import Sequence

import numpy as np

from realitygap.check.follow import EXPLAINED, WEAK, Following
from realitygap.check.mistake import Certainty, Mistake
from realitygap.check.observed import Observed
from realitygap.check.servo import stiffness
from realitygap.check.velocity import travels
from realitygap.check.words import STRONGEST, unit, wide
from realitygap.check.zero import unloaded_error
from realitygap.recording.commands import held_at
from realitygap.trace.trace import Array

TOLD, TOLD_SLIDE = 0.35, 0.05
"""rad (20°) and m: friction holds a joint still while its command moves by twice friction over stiffness: by less than
0.02 rad of eight machines, and by a fifth of this where the gain is `WEAK` times less than it says."""
WENT, WENT_SLIDE = 0.1, 0.01
"""rad and m: so much more than in its least stretch a velocity goes in one of its stretches of time; noise comes to a
tenth of that."""
FEWEST = 10
"""Samples that tell that a reading never changes."""
AROUND = 5
"""Steps between readings, before and after, that tell how fast a joint moved there."""
JUMPS, JUMP_QUANTA = 5.0, 20.0
"""Such steps, and quanta of the sensor, that a jump has into equal readings and out of them: 2 of the larger of both
was the most of 274 recordings of seven machines, by backlash and stiction; readings lost as zeros had 18, and 178
quanta."""
BESIDE, BESIDE_SLIDE = 0.7, 0.1
"""rad (40°) and m: twice what a robot that holds its first command sags by at most (`start.FAR`). Six real machines are
0.08 rad from it all along, at most."""
ZERO, ZERO_SLIDE = 0.2, 0.03
"""rad (11°) and m: so far from its command without effort is none of a servo, however weak. Of 750 recordings of joints
with planted effects it was 0.05 rad at most, of 648 with gains down to a sixteenth 0.05, of four machines 0.04."""
LEAST_SLOPE = 0.5
"""The least that a position moves per command where it follows it: weaker, a sag is what the servo is."""


def stuck_readings(o: Observed) -> list[Mistake]:
    """Positions that never change while the command or the reported velocity says that the joint moves, or not for a
    while, with a jump before and after.

    A servo that is off, whose commands are none, may stand still.
    """
    position, found, out = o.recording.trace.position, travels(o), []
    if position is None:
        return []
    told = wide(o.command)
    went = np.zeros(len(o.joints)) if found is None else wide(found[1])
    fastest = np.zeros(len(o.joints)) if o.velocity is None else np.abs(np.nan_to_num(o.velocity)).max(axis=0)
    for j, joint in enumerate(o.joints):
        known = position[np.isfinite(position[:, j]), j]
        if len(known) < FEWEST:
            continue
        if np.ptp(known) > 0.0:
            out += _lost_readings(o, j, position[:, j])
            continue
        asked = bool(o.follows[j]) and told[j] > (TOLD_SLIDE if o.prismatic(j) else TOLD)
        moved = went[j] > (WENT_SLIDE if o.prismatic(j) else WENT)
        if not (asked or moved):
            continue
        rad = unit(o, j)
        says = [f"its command moves by {told[j]:.3g} {rad}"] if asked else []
        says += [f"its reported velocity reaches {fastest[j]:.3g} {rad}/s"] if moved else []
        sentence = (
            f"the position of {joint} never changes from {known[0]:.4g} {rad}, while {' and '.join(says)}: a stuck "
            "encoder, a wrong column, or a servo that was off; expected the position that was measured, or no command "
            "where the servo was off"
        )
        certainty: Certainty = "certain" if moved else "likely"
        out.append(Mistake("stuck_position", certainty, (joint,), sentence, o.line("position"), (o.name,)))
    return out


def _lost_readings(o: Observed, j: int, value: Array) -> list[Mistake]:
    """Equal readings, of all (t,) of a joint, between two jumps that neither its speed nor its command explains.

    Only its command tells such jumps from steps that a servo makes between two slow samples.
    """
    time, steps = o.recording.trace.time, np.diff(value)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], steps == 0.0, [False]]).astype(int)))
    if not o.follows[j]:
        return []
    command, found = held_at(o.recording.command_time, o.recording.command[:, j], time), []
    for first, last in edges.reshape(-1, 2):  # of the readings of a stretch
        if last - first + 1 < FEWEST or first == 0 or last == len(steps):
            continue
        around = np.abs(np.concatenate([steps[max(first - 1 - AROUND, 0) : first - 1], steps[last + 1 :][:AROUND]]))
        jumps = np.abs(steps[[first - 1, last]])
        usual = max(JUMPS * around.max(initial=0.0), JUMP_QUANTA * o.quantum[j])
        told = [np.ptp(command[max(at - FEWEST, 0) : at + 1]) for at in (first, last + 1)]  # NaN where it is off
        if (jumps > usual).all() and (np.array(told) < jumps / 2.0).all():
            found.append((last - first + 1, first, last, jumps))
    if not found:
        return []
    count, first, last, jumps = max(found, key=lambda f: int(f[0]))
    rad, more = unit(o, j), len(found) - 1
    also = f", and in {more} other stretch{'es' * (more > 1)}" if more else ""
    sentence = (
        f"the position of {o.joints[j]} is exactly {value[first]:.4g} {rad} in {count} readings from {time[first]:.3f} "
        f"to {time[last]:.3f} s{also}, with jumps of {jumps[0]:.3g} and {jumps[1]:.3g} {rad} that its speed and its "
        "command do not explain: readings that were lost; expected what was measured, or empty cells where nothing was"
    )
    return [Mistake("stuck_position", "likely", (o.joints[j],), sentence, o.line("position"), (o.name,))]


def beside_command(o: Observed, along: Following, joints: Sequence[int]) -> list[Mistake]:
    """Positions that follow their command as far as it goes, and are as far from it as no servo sags: all along, or
    where the effort that was measured is none.

    All along is, on a fixed base, also `WEAK` times what moving its links takes of the servo: a load or a gain may be
    off. Without a measured effort a spring or a load that no model has may do less than that.
    """
    out = []
    for j in joints:
        error = o.position[:, j] - o.command[:, j]
        error = error[np.isfinite(error)]
        share, slope = np.nan_to_num(along.share[j, j]), np.nan_to_num(along.slope[j, j])
        if not (share >= EXPLAINED and LEAST_SLOPE <= slope <= STRONGEST and len(error)):
            continue
        middle, where = float(np.median(error)), "throughout"
        least = float(np.quantile(np.sign(middle) * error, 0.05))
        if least <= max(BESIDE_SLIDE if o.prismatic(j) else BESIDE, _sag(o, j)):
            middle, where = unloaded_error(o, j), "where its measured effort is none, whichever way it moves"
            if abs(middle) <= (ZERO_SLIDE if o.prismatic(j) else ZERO):
                continue
        degrees = "" if o.prismatic(j) else f" ({np.rad2deg(middle):.0f}°)"
        sentence = (
            f"the position of {o.joints[j]} is {middle:+.3g} {unit(o, j)}{degrees} from its command {where}, and "
            f"follows it otherwise (explains {share:.1%}): another zero or mounting offset, another unit, or another "
            "joint; expected both to count from the URDF's zero"
        )
        out.append(Mistake("far_zero", "likely", (o.joints[j],), sentence, o.line("position"), (o.name,)))
    return out


def _sag(o: Observed, j: int) -> float:
    """How far a load may pull a joint of a fixed base from its command [rad or m]."""
    if o.plant.model.floating:
        return 0.0
    return WEAK * float(np.quantile(np.abs(o.needed_effort[:, j]), 0.95) / stiffness(o)[j])
