"""From the units of a table to SI."""

from collections.abc import Sequence
from fnmatch import fnmatchcase
from pathlib import Path

import numpy as np

from realitygap.files.errors import InputError
from realitygap.scenario.schema import Length, Lengths
from realitygap.trace.trace import Array

SECONDS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
LENGTHS = {"rad": 1.0, "deg": np.pi / 180, "m": 1.0, "mm": 1e-3}


def unit_of(units: Lengths, joint: str) -> Length | None:
    """The unit of a joint: that of the first pattern that matches; None where none does."""
    return units if isinstance(units, str) else next((u for p, u in units.items() if fnmatchcase(joint, p)), None)


def joint_factors(units: Lengths, joints: Sequence[str], key: str, file: Path) -> Array:
    """SI per recorded unit of every joint; the first pattern that matches counts. Shape (n,).

    Raises:
        InputError: for a joint that no pattern matches.
    """
    out = []
    for joint in joints:
        found = unit_of(units, joint)
        if found is None:
            raise InputError(f"{file}: {key}: no pattern matches joint {joint}; expected a unit for every joint")
        out.append(LENGTHS[found])
    return np.array(out)
