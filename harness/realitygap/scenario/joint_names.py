"""What a recording calls the robot's joints, where it has other names for them."""

from collections.abc import Collection, Mapping, Sequence
from fnmatch import fnmatchcase
from pathlib import Path

from realitygap.files.errors import InputError

KEY = "recordings.joints"
JOINT = "*"
"""What stands for the joint's own name in a name that holds for several."""


def recorded_names(stated: Mapping[str, str], joints: Sequence[str], file: Path) -> tuple[str, ...]:
    """The recording's name of every joint; its own, where nothing is stated for it. Shape (n,).

    Args:
        stated: names by patterns over joint names, the first that matches; `*` in a name is the joint's own.
        joints: the robot's joints.
        file: the scenario file, for messages.

    Raises:
        InputError: for a pattern that matches no joint, or a name that two joints get.
    """
    for pattern in stated:
        if not any(fnmatchcase(joint, pattern) for joint in joints):
            raise InputError(f"{file}: {KEY}: {pattern} matches no joint; the robot has {', '.join(joints)}")
    patterns = {joint: next((p for p in stated if fnmatchcase(joint, p)), None) for joint in joints}
    names = {joint: joint if p is None else stated[p].replace(JOINT, joint) for joint, p in patterns.items()}
    owners: dict[str, str] = {}
    for joint, name in names.items():
        if (other := owners.setdefault(name, joint)) != joint:
            raise InputError(
                f"{file}: {KEY}: gives {other} and {joint} the same name {name}; expected another for each (`*` in it "
                "stands for the joint's own)"
            )
    return tuple(names.values())


def name_patterns(found: Collection[str], joints: Sequence[str]) -> list[str]:
    """The names that would bring all joints to those of a recording, as `left_arm/*`; none if they differ more."""
    if not joints:
        return []
    first, there = joints[0], set(found)
    out = []
    for name in sorted(there - {first}):
        at = name.find(first)
        while at >= 0:
            before, after = name[:at], name[at + len(first) :]
            if all(f"{before}{joint}{after}" in there for joint in joints):
                out.append(f"{before}{JOINT}{after}")
            at = name.find(first, at + 1)
    return out


def hint(found: Collection[str], joints: Sequence[str]) -> str:
    """What to write in a scenario whose recording has these names instead of the joints'."""
    patterns = name_patterns(found, joints)
    written = [f'{{"*": "{pattern}"}}' for pattern in patterns[:2]] or [f"{{{joints[0]}: ITS NAME THERE}}"]
    return f"{KEY}: {' or '.join(written)}"
