"""What planted effects are drawn with."""

from collections.abc import Callable

import numpy as np
from foreign import Foreign
from robots import Robot

Rng = np.random.Generator
Values = dict[str, float]
Plant = Callable[[Foreign, Robot, int, float, Rng], Values]


def sign(rng: Rng) -> float:
    """1 or -1."""
    return 1.0 if rng.random() < 0.5 else -1.0


def factor(rng: Rng, size: float) -> float:
    """A wrong value in the model: 18 to 30 per cent off at size 1."""
    return max(0.4, 1.0 + sign(rng) * rng.uniform(0.18, 0.30) * size)
