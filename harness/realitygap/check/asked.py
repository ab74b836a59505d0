"""Commands that are efforts, where the scenario takes them for positions.

The measured effort is then the command itself, far more than what any servo makes of an error, and the position does
not follow it.
"""

import numpy as np

from realitygap.check.effort import DELAYS, fit_servo
from realitygap.check.follow import WEAK, following
from realitygap.check.mistake import Mistake
from realitygap.check.observed import Mask, Observed
from realitygap.check.words import FAR_BETTER, STRONGEST, WEAKEST

ALIKE = 0.98
"""The share of an effort that the command explains, as what was asked for: 0.998 of motors with current controllers."""
FOLLOWED = 0.95
"""The position of a servo that does what it is told is explained by its command to more than this."""


def asked_efforts(o: Observed, moving: Mask) -> list[Mistake]:
    """Commands of moving joints (n,) that are the efforts which were measured."""
    if o.effort is None or len(o.clock) < 50:
        return []
    out: list[Mistake] = []
    follows = None
    for j in np.flatnonzero(moving & o.follows):
        share = _share(o, int(j))
        if share < ALIKE or 1.0 - _by_servo(o, int(j)) <= FAR_BETTER * (1.0 - share):
            continue
        follows = following(o.command, o.position, o.step)[1] if follows is None else follows
        part, slope = np.nan_to_num(follows.share[j, j]), np.nan_to_num(follows.slope[j, j])
        if part > FOLLOWED and WEAKEST < slope < STRONGEST:
            continue
        sentence = (
            f"the command of {o.joints[j]} explains {share:.1%} of its effort, and its position is {slope:.2g} times "
            f"the command (explains {part:.0%}): an effort that was asked for, as it seems; expected a position, or "
            "`as: effort` and a servo of `kind: effort`"
        )
        out.append(Mistake("asked_effort", "likely", (o.joints[j],), sentence, "motion", (o.name,)))
    return out


def _by_servo(o: Observed, j: int) -> float:
    """What the servo explains of its effort, with about the stiffness that the scenario says."""
    fits = [fit_servo(o, j, j, delay) for delay in DELAYS]
    return max([f.share for f in fits if 1 / WEAK < f.ratio < WEAK], default=0.0)


def _share(o: Observed, j: int) -> float:
    """The share of an effort that is the command of the same joint, with a positive factor."""
    assert o.effort is not None
    effort, command = o.effort[:, j], o.command[:, j]
    known = np.isfinite(effort) & np.isfinite(command)
    if known.sum() < 50 or not np.ptp(effort[known]) or not np.ptp(command[known]):
        return 0.0
    return float(max(np.corrcoef(command[known], effort[known])[0, 1], 0.0) ** 2)
