"""What the recordings of several runs say of the same values, and how far they agree."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import ndtri, stdtrit

from realitygap.robot.drive import Array

Z95 = float(ndtri(0.975))
"""Standard errors that 95 % are within."""


@dataclass(frozen=True)
class Seen:
    """What one run says of an effect.

    Attributes:
        values: of its parameters.
        fault: whether they are another than the scenario has.
    """

    values: tuple[float, ...]
    fault: bool


def standard_errors(runs: Sequence[Seen]) -> Array | None:
    """Of the mean of every value, as runs scatter. Shape (k,).

    Of few runs they are as much larger as Student's distribution is wider than a normal one; None of only one.
    """
    if len(runs) < 2:
        return None
    wider = float(stdtrit(len(runs) - 1, 0.975)) / Z95
    return np.asarray(np.std([run.values for run in runs], axis=0, ddof=1) * wider / np.sqrt(len(runs)))
