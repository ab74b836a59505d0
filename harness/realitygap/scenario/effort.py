"""What a recorded effort means: N·m (or N) per recorded unit, joint by joint."""

from collections.abc import Sequence
from fnmatch import fnmatchcase
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from realitygap.files.errors import InputError
from realitygap.scenario.schema import EffortStream

Array = NDArray[np.float64]
FIT = "fit"
"""In place of a factor that is left to the recordings."""


def effort_factors(effort: EffortStream, joints: Sequence[str], file: Path) -> Array:
    """N·m (or N) per recorded unit of every joint, 1 where it is to be fitted. Shape (n,).

    Raises:
        InputError: for a pattern that matches no joint, or a joint that none matches.
    """
    return np.array([1.0 if v == FIT else v for v in _stated(effort, joints, file)], dtype=float)


def fitted_factors(effort: EffortStream, joints: Sequence[str], file: Path) -> list[int]:
    """The joints whose factor is to be fitted. Raises InputError as `effort_factors`."""
    return [j for j, v in enumerate(_stated(effort, joints, file)) if v == FIT]


def _stated(effort: EffortStream, joints: Sequence[str], file: Path) -> list[float | str]:
    if not isinstance(effort.factor, dict):
        return [effort.factor] * len(joints)
    patterns = list(effort.factor)
    for pattern in patterns:
        if not any(fnmatchcase(joint, pattern) for joint in joints):
            raise InputError(
                f"{file}: recordings.effort.factor: {pattern} matches no joint; the robot has {', '.join(joints)}"
            )
    out: list[float | str] = []
    for joint in joints:
        found = next((p for p in patterns if fnmatchcase(joint, p)), None)
        if found is None:
            raise InputError(
                f"{file}: recordings.effort.factor: says nothing for {joint}; expected a pattern that matches it "
                f"beside {', '.join(patterns)}"
            )
        out.append(effort.factor[found])
    return out
