"""Numbers and names as the sentences of all checks say them."""

from collections.abc import Sequence

import numpy as np

from realitygap.check.observed import Observed
from realitygap.trace.trace import Array

FACTORS = {"degrees": 180.0 / np.pi, "thousandths": 1000.0}
"""What a quantity is larger by in the unit that it should not have."""
WEAKEST, STRONGEST = 0.2, 1.6
"""A joint moves by this share of its command: less with weak gains (0.25 was measured, of a small servo with P 100),
more where it overshoots."""
FAR_BETTER = 4.0
"""An explanation is far better than another that leaves this many times more variance: beyond the 99.9 % point of an
F test with 20 degrees of freedom each (3.6 to 4.3), which a few seconds of motion have."""


def joined(names: Sequence[str]) -> str:
    """Names in a sentence."""
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"


def unit(o: Observed, joint: int) -> str:
    """The unit of a joint's position."""
    return "m" if o.prismatic(joint) else "rad"


def effort_unit(o: Observed, joint: int) -> str:
    """The unit of a joint's effort."""
    return "N" if o.prismatic(joint) else "N·m"


def factor_of(o: Observed, joint: int, slope: float, weakest: float = WEAKEST) -> tuple[str, float] | None:
    """The kind of mistake and the factor that a slope shows, and 1 over it where the other side has it; None: neither.

    The bands of 57.3, 1000 and their inverses with weak and with overshooting joints do not touch one another or 1.
    """
    for kind, factor in FACTORS.items():
        if kind == "degrees" and o.prismatic(joint):
            continue
        if weakest <= abs(slope) / factor <= STRONGEST:
            return kind, factor
        if max(weakest, 0.4) <= abs(slope) * factor <= STRONGEST:
            return kind, 1.0 / factor
    return None


def wide(value: Array) -> Array:
    """The range of every column, without NaN. Shape (k, n), gives (n,)."""
    known = np.isfinite(value)
    high = np.where(known, value, -np.inf).max(axis=0, initial=-np.inf)
    low = np.where(known, value, np.inf).min(axis=0, initial=np.inf)
    return np.asarray(np.where(known.any(axis=0), high - low, 0.0))
