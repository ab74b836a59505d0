"""Which joints a scenario holds fixed, and where."""

from collections.abc import Mapping
from fnmatch import fnmatchcase

from realitygap_engines.model.robot import Model

from realitygap.files.errors import InputError
from realitygap.scenario.file import ScenarioFile

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
            joint = model.joints[i]
            if not joint.lower - SPARE <= position <= joint.upper + SPARE:
                raise InputError(
                    f"{file.path}: robot.hold: {pattern}: found {position:g}, which is outside the limits of "
                    f"{joint.name}, {joint.lower:g} to {joint.upper:g}"
                )
            found.setdefault(i, position)
    if found and len(found) == len(model.joints) and not model.floating:
        raise InputError(
            f"{file.path}: robot.hold: holds all of {', '.join(model.joint_names)}; expected one that moves"
        )
    return found
