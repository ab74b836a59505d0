"""Where a scenario says that joints stand: those that it holds fixed, and all at the start."""

from collections.abc import Mapping
from fnmatch import fnmatchcase

import numpy as np
from realitygap_engines.model.robot import Joint, Model

from realitygap.files.errors import InputError
from realitygap.scenario.file import ScenarioFile
from realitygap.trace.trace import Array

SPARE = 0.01
"""A position may lie this far outside a joint's limits [rad or m]."""


def held_joints(file: ScenarioFile, model: Model, wanted: Mapping[str, float]) -> dict[int, float]:
    """The position at which a scenario holds joints, by their index.

    Raises:
        InputError: for a pattern that matches no joint, a position outside its limits, or a robot that could not move.
    """
    found: dict[int, float] = {}
    for pattern, position in wanted.items():
        matched = [i for i, name in enumerate(model.joint_names) if fnmatchcase(name, pattern)]
        if not matched:
            raise InputError(
                f"{file.path}: robot.hold: {pattern} matches no joint; the robot has {', '.join(model.joint_names)}"
            )
        for i in matched:
            _check_within(f"{file.path}: robot.hold: {pattern}", model.joints[i], position)
            found.setdefault(i, position)
    if found and len(found) == len(model.joints) and not model.floating:
        raise InputError(
            f"{file.path}: robot.hold: holds all of {', '.join(model.joint_names)}; expected one that moves"
        )
    return found


def stated_start(model: Model, wanted: Mapping[str, float]) -> Array:
    """The positions at which a scenario starts the joints [rad or m], 0 where it says none. Shape (n,).

    Raises:
        InputError: for a joint that is not there, or a position outside its limits.
    """
    names = model.joint_names
    position = np.zeros(len(names))
    for name, value in wanted.items():
        if name not in names:
            raise InputError(f"robot.start: found joint {name!r}; the robot has {', '.join(names)}")
        _check_within(f"robot.start: {name}", model.joints[names.index(name)], value)
        position[names.index(name)] = value
    return position


def _check_within(key: str, joint: Joint, position: float) -> None:
    low, high = joint.lower - SPARE, joint.upper + SPARE
    if low <= position <= high:
        return
    degrees = "" if joint.prismatic or not low <= np.deg2rad(position) <= high else "; degrees?"
    raise InputError(
        f"{key}: found {position:g}, which is outside the limits of {joint.name}, {joint.lower:g} to {joint.upper:g} "
        f"{'m' if joint.prismatic else 'rad'}{degrees}"
    )
