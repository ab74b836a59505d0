"""All checks of one scenario, and what the other commands ask of them."""

from collections.abc import Iterable, Sequence
from fnmatch import fnmatchcase
from shlex import quote

import numpy as np

from realitygap.check.asked import asked_efforts
from realitygap.check.clocks import clock_offset, no_overlap, time_unit
from realitygap.check.commanded_effort import commanded_efforts
from realitygap.check.counts import count_mistakes
from realitygap.check.coupling import coupling_mistakes
from realitygap.check.driven import drives_nothing, servo_patterns, undriven
from realitygap.check.effort import effort_mistakes
from realitygap.check.effort_flag import effort_flags
from realitygap.check.few import few_samples
from realitygap.check.limits import angle_mistakes, limit_mistakes
from realitygap.check.links import link_mistakes
from realitygap.check.load import load_mistakes
from realitygap.check.mistake import KINDS, Mistake, merged
from realitygap.check.motion import motion_mistakes, moving
from realitygap.check.observed import Mask, Observed, Read, observe
from realitygap.check.reading import stuck_readings
from realitygap.check.repetitions import repetition_mistakes
from realitygap.check.speed_limit import speed_limit_mistakes
from realitygap.check.start import constant_command, start_mistakes
from realitygap.check.velocity import usual_slopes, velocity_mistakes
from realitygap.check.welded import welded_mistakes
from realitygap.check.window import window_mistakes
from realitygap.files.errors import InputError, did_you_mean
from realitygap.recording import read_recording
from realitygap.robot.plant import Plant, build_plant
from realitygap.robot.suspicion import check_suspicion
from realitygap.scenario.file import ScenarioFile

SHIFTED = ("another_motion", "flipped_sign")
"""What a recording whose clocks differ may look like, too, where its offset is not seen: a sine half a period late."""


def check(file: ScenarioFile, read: Read = read_recording) -> list[Mistake]:
    """Every mistake in a scenario, its robot and its recordings, certain ones first, also those that it accepts.

    No physics is simulated and none is blamed: what a servo, a load or friction can do is no mistake.

    Raises:
        InputError: for what cannot be read at all, or a key of the scenario that names what does not exist.
    """
    observed = observe(file, read)
    plants = list({id(o.plant): o.plant for o in observed}.values()) or [build_plant(file)]
    _check_accepted(file, plants)
    check_suspicion(file, plants[0].model)
    found = servo_patterns(file, plants)
    whole = drives_nothing(file, plants, observed)
    found += [m for plant in plants for m in (*limit_mistakes(plant), *link_mistakes(plant))]
    found += _of_recordings(observed, bool(whole))
    welded = welded_mistakes(file, observed, read)
    if not found and not whole:
        found += load_mistakes(observed)
    if not whole and not any(m.certainty == "certain" for m in found):
        found += repetition_mistakes(observed, _joints(found))
    return merged([*whole, *found, *welded, *(m for o in observed for m in (*few_samples(o), *window_mistakes(o)))])


def certain(file: ScenarioFile, read: Read = read_recording) -> list[Mistake]:
    """The likely mistakes in a scenario, as warnings; those that it accepts are left out.

    Raises:
        InputError: for a certain mistake, in one sentence; and as `check`.
    """
    found = [m for m in check(file, read) if not accepted(file, m)]
    sure = [m for m in found if m.certainty == "certain"]
    if sure:
        more = "" if len(sure) == 1 else f" ({len(sure) - 1} more: `realitygap check {quote(str(file.path))}`)"
        raise InputError(f"{file.path}: {sure[0].text}{more}")
    return found


def accepted(file: ScenarioFile, mistake: Mistake) -> bool:
    """Whether the scenario's `accept` says that this is none: its kind, at all of its joints."""
    where = [w or "*" for k, _, w in (entry.partition("@") for entry in file.scenario.accept) if k == mistake.kind]
    names = mistake.joints or ("",)
    return bool(where) and all(any(fnmatchcase(name, w) for w in where) for name in names)


def blamed_joints(warnings: Iterable[Mistake]) -> set[str]:
    """The joints at which a mistake is likely, so that no physics is named there."""
    return _joints(warnings)


def _of_recordings(observed: Sequence[Observed], undriven_robot: bool) -> list[Mistake]:
    """What is wrong with the recordings. What follows from another mistake, in any of them, is not told again."""
    counts = {id(o): count_mistakes(o) for o in observed}
    in_rad = {id(o): _without(o, _joints(counts[id(o)])) for o in observed}
    clocks = {id(o): time_unit(o, in_rad[id(o)]) or no_overlap(o) for o in observed}
    found = [m for o in observed for m in clocks[id(o)]]
    rest = [o for o in observed if not clocks[id(o)]]
    late: list[Mistake] = []
    if not undriven_robot:
        late = [m for o in rest for m in clock_offset(o, moving(o))]
        found += [*late, *(m for o in rest for m in undriven(o))]
    shifted = {run for m in late for run in m.runs}
    stuck = [m for o in rest for m in stuck_readings(o)]

    def stands(m: Mistake) -> bool:
        """Whether it is more than what readings that are stuck for a while make likely."""
        return m.certainty == "certain" or not _joints(stuck) & set(m.joints)

    angles = [m for o in rest for m in counts[id(o)]]
    if not undriven_robot and not late:
        angles += [m for o in rest for m in asked_efforts(o, moving(o) & in_rad[id(o)])]
    asked = _joints(angles)
    for o in rest:
        if not undriven_robot and o.name not in shifted:
            seen = [m for m in motion_mistakes(o, rest) if not late or m.kind not in SHIFTED]
            angles += [m for m in seen if not asked & set(m.joints) and stands(m)]
        angles += [m for m in angle_mistakes(o) if not _joints(angles) & set(m.joints)]
    uncoupled = [m for o in rest for m in coupling_mistakes(o, _without(o, _joints(angles)))]
    found += [*angles, *uncoupled]
    usual = usual_slopes(rest)
    speeds = [m for o in rest for m in velocity_mistakes(o, _without(o, _joints(angles)), usual)]
    named = _joints(m for m in speeds if m.kind != "velocity")  # in any of them
    found += [m for m in speeds if stands(m) and (m.kind != "velocity" or not named & set(m.joints))]
    found += [m for m in stuck if not _joints(found) & set(m.joints)]
    if undriven_robot or late:
        return found
    held = [m for o in rest for m in constant_command(o)]
    found += [m for m in held if not _joints(found) & set(m.joints)]
    told = _joints(found)
    found += [m for o in rest for m in start_mistakes(o) if not told & set(m.joints)]
    flags = [m for m in effort_flags(rest) if not told & set(m.joints)]
    found, told = [*found, *flags], told | _joints(flags)
    asked_for = [m for o in rest for m in commanded_efforts(o, _without(o, told))]
    found, told = [*found, *asked_for], told | _joints(asked_for)
    heavy = load_mistakes([o for o in rest if o.follows.any()])
    efforts = [(o, not heavy and not link_mistakes(o.plant)) for o in rest]
    found += _plainest([m for o, known in efforts for m in effort_mistakes(o, _without(o, told), weighed=known)])
    told = _joints(found)
    return found + [m for o in rest for m in speed_limit_mistakes(o, _without(o, told))]


def _plainest(mistakes: Sequence[Mistake]) -> list[Mistake]:
    """Of several things that recordings show of one joint's effort, the one that explains the others."""
    order = ("swapped_joints", "milliamperes", "flipped_sign", "effort_size", "effort_direction")
    out: list[Mistake] = []
    for kind in order:
        told = _joints(out)
        out += [m for m in mistakes if m.kind == kind and not told & set(m.joints)]
    return out


def _joints(mistakes: Iterable[Mistake]) -> set[str]:
    return {joint for m in mistakes for joint in m.joints}


def _without(o: Observed, names: set[str]) -> Mask:
    return np.array([joint not in names for joint in o.joints])


def _check_accepted(file: ScenarioFile, plants: Sequence[Plant]) -> None:
    names = [name for plant in plants for name in plant.model.joint_names]
    for i, entry in enumerate(file.scenario.accept):
        kind, _, where = entry.partition("@")
        if kind not in KINDS:
            known = ", ".join(KINDS)
            raise InputError(
                f"{file.path}: accept[{i}]: found {entry}; expected one of {known}{did_you_mean(kind, KINDS)}"
            )
        if where and not any(fnmatchcase(name, where) for name in names):
            raise InputError(
                f"{file.path}: accept[{i}]: {where} matches no joint; the robot has {', '.join(dict.fromkeys(names))}"
            )
