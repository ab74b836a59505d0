"""Joints that mimic others: every one is led back to a joint that is free."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from realitygap_engines.errors import ModelError
from realitygap_engines.model.robot import Joint, Mimic


def resolved(path: Path, joints: Sequence[Joint]) -> tuple[Joint, ...]:
    """The joints with every mimic of a mimic as one of the joint that leads both.

    Raises:
        ModelError: for a mimic of a joint that is not there or does not move, in a circle, or of what is no number.
    """
    known = {joint.name: joint for joint in joints}
    return tuple(replace(j, mimic=_led(path, j, known)) if j.mimic is not None else j for j in joints)


def _led(path: Path, joint: Joint, known: dict[str, Joint]) -> Mimic:
    multiplier, offset, at, passed = 1.0, 0.0, joint, [joint.name]
    while at.mimic is not None:
        mimic = at.mimic
        if not np.isfinite([mimic.multiplier, mimic.offset]).all() or mimic.multiplier == 0:
            raise ModelError(
                f"{path}: joint {at.name} mimics {mimic.joint} {mimic.multiplier:g} times plus {mimic.offset:g}; "
                "expected finite numbers, and a multiplier that is not 0"
            )
        if mimic.joint not in known:
            raise ModelError(
                f"{path}: joint {at.name} mimics {mimic.joint}; expected one of the moving joints {', '.join(known)}"
            )
        offset += multiplier * mimic.offset
        multiplier *= mimic.multiplier
        at = known[mimic.joint]
        if at.name in passed:
            raise ModelError(f"{path}: joint {joint.name} mimics itself, through {', '.join(passed)}")
        passed.append(at.name)
    return Mimic(at.name, multiplier, offset)
