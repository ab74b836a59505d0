"""When a simulation has blown up, and at which joint it shows."""

import numpy as np

from realitygap_engines.errors import Diverged
from realitygap_engines.model.robot import Array, Model

RUNAWAY = 1e6
"""A speed that no robot has [rad/s or m/s]."""


def diverged(model: Model, time: float, values: Array, what: str) -> Diverged:
    """The blow-up at a time [s], at the first joint whose value (n,) is none or runs away, otherwise at the base."""
    wrong = np.flatnonzero(~(np.abs(values) < RUNAWAY))
    return Diverged(time, model.joints[wrong[0]].name if len(wrong) else "base", what)
