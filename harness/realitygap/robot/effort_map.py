"""An effort that depends on one or two measured variables, as a table: what no law explains."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from realitygap.robot.drive import Array

VARIABLES = {
    "angle": "rad",
    "speed": "rad/s",
    "error": "rad",
    "load": "N·m",
    "reversal": "s",
    "supply": "V",
}
"""What an effort can depend on, as it is measured, with its unit. Their order is that of the codes in `MAP`.

angle, speed: what the encoder reads. error: command less reading, 0 where the servo is off. load: what moving the link
takes, signed: the torque that gears and maps hand to it. reversal: time since the encoder's speed last changed its
sign, or since the beginning. supply: the voltage that was recorded, else the servo's bus.
"""

MAP = np.dtype(
    [
        ("joint", np.int64),
        ("first", np.int64),  # codes of the variables; -1: there is no second one
        ("second", np.int64),
        ("rows", np.int64),  # how many knots each has
        ("columns", np.int64),
        ("at", np.int64),  # where its numbers begin: knots of the first, of the second, values row by row
    ]
)
"""Where a map's numbers are."""


@dataclass(frozen=True)
class EffortMap:
    """An effort on one joint that is linear between knots, and constant beyond the first and the last.

    Attributes:
        joint: index of the joint.
        variables: one or two names of `VARIABLES`.
        knots: increasing, for each variable.
        values: effort [N·m or N] at the knots, row by row: the second variable's knots run fastest.
    """

    joint: int
    variables: tuple[str, ...]
    knots: tuple[tuple[float, ...], ...]
    values: tuple[float, ...]


@dataclass(frozen=True)
class Table:
    """What an effort depends on, and the knots between which it is linear, before its values are known.

    Attributes:
        variables: one or two names of `VARIABLES`.
        knots: increasing, for each variable.
    """

    variables: tuple[str, ...]
    knots: tuple[tuple[float, ...], ...]

    @property
    def names(self) -> tuple[str, ...]:
        """Of its values, row by row: the second variable's knots run fastest."""
        return tuple(f"value_{k + 1}" for k in range(int(np.prod([len(row) for row in self.knots]))))

    def parameters(self, values: Sequence[float]) -> dict[str, object]:
        """What a scenario says of it: variables, knots and values; of two variables, values is a row per knot."""
        width = len(self.knots[-1])
        rows = [list(values[k : k + width]) for k in range(0, len(values), width)]
        return {
            "variables": list(self.variables),
            "knots": [list(row) for row in self.knots],
            "values": rows if len(self.variables) > 1 else list(values),
        }


def packed(maps: Sequence[EffortMap]) -> tuple[NDArray[np.void], Array]:
    """All maps as the compiled law reads them: where each one's numbers are, shape (m,) of `MAP`, and the numbers."""
    codes = list(VARIABLES)
    table, numbers = np.zeros(len(maps), MAP), list[float]()
    for row, one in zip(table, maps, strict=True):
        second = codes.index(one.variables[1]) if len(one.variables) > 1 else -1
        columns = one.knots[1] if len(one.knots) > 1 else (0.0,)
        row["joint"], row["first"], row["second"] = one.joint, codes.index(one.variables[0]), second
        row["rows"], row["columns"], row["at"] = len(one.knots[0]), len(columns), len(numbers)
        numbers += itertools.chain(one.knots[0], columns, one.values)
    return table, np.array(numbers)
