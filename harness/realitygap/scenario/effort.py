"""What a recorded effort means: N·m (or N) per recorded unit, joint by joint."""

from collections.abc import Sequence
from fnmatch import fnmatchcase
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from realitygap.files.errors import InputError
from realitygap.scenario.schema import EffortStream

Array = NDArray[np.float64]


def effort_factors(effort: EffortStream, joints: Sequence[str], file: Path) -> Array:
    """N·m (or N) per recorded unit of every joint. Shape (n,).

    Raises:
        InputError: for a pattern that matches no joint, or a joint that none matches.
    """
    if not isinstance(effort.factor, dict):
        return np.full(len(joints), effort.factor)
    patterns = list(effort.factor)
    for pattern in patterns:
        if not any(fnmatchcase(joint, pattern) for joint in joints):
            raise InputError(
                f"{file}: recordings.effort.factor: {pattern} matches no joint; the robot has {', '.join(joints)}"
            )
    out = np.empty(len(joints))
    for j, joint in enumerate(joints):
        found = next((p for p in patterns if fnmatchcase(joint, p)), None)
        if found is None:
            raise InputError(
                f"{file}: recordings.effort.factor: says nothing for {joint}; expected a pattern that matches it "
                f"beside {', '.join(patterns)}"
            )
        out[j] = effort.factor[found]
    return out
