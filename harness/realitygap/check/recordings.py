"""What is wrong with recordings, causes first: what follows from another mistake, in any of them, is not told again."""

from collections.abc import Iterable, Sequence

import numpy as np

from realitygap.check.asked import asked_efforts
from realitygap.check.clocks import clock_offset, no_overlap, time_unit
from realitygap.check.commanded_effort import commanded_efforts
from realitygap.check.counts import count_mistakes
from realitygap.check.coupling import coupling_mistakes
from realitygap.check.driven import undriven
from realitygap.check.effort import effort_mistakes
from realitygap.check.effort_flag import effort_flags
from realitygap.check.limits import angle_mistakes
from realitygap.check.links import link_mistakes
from realitygap.check.load import load_mistakes
from realitygap.check.mistake import Mistake
from realitygap.check.motion import motion_mistakes, moving
from realitygap.check.observed import Mask, Observed
from realitygap.check.reading import stuck_readings
from realitygap.check.speed_limit import speed_limit_mistakes
from realitygap.check.start import constant_command, start_mistakes
from realitygap.check.strays import stray_readings
from realitygap.check.velocity import usual_slopes, velocity_mistakes

SHIFTED = ("another_motion", "flipped_sign")
"""What a recording whose clocks differ may look like, too, where its offset is not seen: a sine half a period late."""
PLAINEST = ("swapped_joints", "milliamperes", "flipped_sign", "effort_size", "effort_direction")
"""What a joint's effort may show, each explained by those before it."""


def recording_mistakes(observed: Sequence[Observed], driven: bool) -> list[Mistake]:
    """What is wrong with the recordings of a robot, some joint of which is driven or none."""
    counts = {id(o): count_mistakes(o) for o in observed}
    clocks = {id(o): time_unit(o, without(o, joints_of(counts[id(o)]))) or no_overlap(o) for o in observed}
    found = [m for o in observed for m in clocks[id(o)]]
    rest = [o for o in observed if not clocks[id(o)]]
    late = [m for o in rest for m in clock_offset(o, moving(o))] if driven else []
    found += [*late, *(m for o in rest if driven for m in undriven(o))]
    stuck = [m for o in rest for m in (*stray_readings(o), *stuck_readings(o))]

    in_counts = [m for o in rest for m in counts[id(o)]]
    asked = [] if late or not driven else _asked_efforts(rest, counts)
    angles = _of_angles(rest, [*in_counts, *asked], late, stuck, driven)
    found += [*angles, *(m for o in rest for m in coupling_mistakes(o, without(o, joints_of(angles))))]
    found += _of_velocities(rest, angles, stuck)
    found += unless(found, stuck)
    if late or not driven:
        return found
    found += unless(found, [m for o in rest for m in constant_command(o)])
    starts = unless(found, [m for o in rest for m in start_mistakes(o)])
    found = _with_efforts(rest, found)
    found += starts
    return found + [m for o in rest for m in speed_limit_mistakes(o, without(o, joints_of(found)))]


def joints_of(mistakes: Iterable[Mistake]) -> set[str]:
    """The joints of which something is told."""
    return {joint for m in mistakes for joint in m.joints}


def without(o: Observed, names: set[str]) -> Mask:
    """Which joints of a recording are none of these."""
    return np.array([joint not in names for joint in o.joints])


def unless(told: Iterable[Mistake], mistakes: Iterable[Mistake]) -> list[Mistake]:
    """The mistakes of joints of which nothing is told."""
    known = joints_of(told)
    return [m for m in mistakes if not known & set(m.joints)]


def _asked_efforts(rest: Sequence[Observed], counts: dict[int, list[Mistake]]) -> list[Mistake]:
    return [m for o in rest for m in asked_efforts(o, moving(o) & without(o, joints_of(counts[id(o)])))]


def _of_angles(
    rest: Sequence[Observed],
    known: Sequence[Mistake],
    late: Sequence[Mistake],
    stuck: Sequence[Mistake],
    driven: bool,
) -> list[Mistake]:
    """What is wrong with angles, beside what is known to be: not of a recording that is late, nor, of any, what that
    may look like.
    """
    shifted = {run for m in late for run in m.runs}
    angles = list(known)
    for o in rest:
        if driven and o.name not in shifted:
            seen = [m for m in motion_mistakes(o, rest) if not late or m.kind not in SHIFTED]
            angles += unless(known, _standing(seen, stuck))
        angles += unless(angles, angle_mistakes(o))
    return angles


def _of_velocities(rest: Sequence[Observed], angles: Sequence[Mistake], stuck: Sequence[Mistake]) -> list[Mistake]:
    """What is wrong with velocities whose angles are right; that they are off is told where nothing says by what, in
    any recording.
    """
    usual = usual_slopes(rest)
    speeds = [m for o in rest for m in velocity_mistakes(o, without(o, joints_of(angles)), usual)]
    named = joints_of(m for m in speeds if m.kind != "velocity")
    return [m for m in _standing(speeds, stuck) if m.kind != "velocity" or not named & set(m.joints)]


def _with_efforts(rest: Sequence[Observed], found: Sequence[Mistake]) -> list[Mistake]:
    """What was found, and what is wrong with efforts beside."""
    out = [*found, *unless(found, effort_flags(rest))]
    out += [m for o in rest for m in commanded_efforts(o, without(o, joints_of(out)))]
    heavy = load_mistakes([o for o in rest if o.follows.any()])
    weighed = {id(o): not heavy and not link_mistakes(o.plant) for o in rest}
    told = joints_of(out)
    return out + _plainest([m for o in rest for m in effort_mistakes(o, without(o, told), weighed=weighed[id(o)])])


def _standing(mistakes: Iterable[Mistake], stuck: Sequence[Mistake]) -> list[Mistake]:
    """Those that are more than what readings that are stuck for a while make likely."""
    known = joints_of(stuck)
    return [m for m in mistakes if m.certainty == "certain" or not known & set(m.joints)]


def _plainest(mistakes: Sequence[Mistake]) -> list[Mistake]:
    """Of several things that recordings show of one joint's effort, the one that explains the others."""
    out: list[Mistake] = []
    for kind in PLAINEST:
        out += unless(out, [m for m in mistakes if m.kind == kind])
    return out
