"""Efforts that are none: constant, or one value and nothing, as of a flag or of a field that a driver does not fill."""

from collections.abc import Sequence

import numpy as np

from realitygap.check.mistake import Mistake
from realitygap.check.motion import moving
from realitygap.check.observed import Observed
from realitygap.check.words import effort_unit

FEWEST = 50
"""Samples of a moving joint that tell an effort that hardly changes from one that was read a few times."""
FIELD = {
    "bag": "`effort: none` under recordings leaves it out",
    "table": "`effort: none` under recordings leaves it out, and columns.effort names another column",
    "data set": "`effort: none` under recordings leaves it out",
}
"""What to do about an effort that is none, by what holds it."""


def effort_flags(observed: Sequence[Observed]) -> list[Mistake]:
    """Efforts of joints that a servo moves, of which all recordings together hold one value, or nothing and one other.

    The coarsest sensor tells more than two efforts of a servo that moves a joint.
    """
    values: dict[str, set[float]] = {}
    counts: dict[str, int] = {}
    where: dict[str, list[Observed]] = {}
    for o in observed:
        effort = o.recording.trace.effort
        if effort is None:
            continue
        for j in map(int, np.flatnonzero(moving(o))):
            known = effort[np.isfinite(effort[:, j]), j]
            values.setdefault(o.joints[j], set()).update(np.unique(known)[:3].tolist())
            counts[o.joints[j]] = counts.get(o.joints[j], 0) + len(known)
            where.setdefault(o.joints[j], []).append(o)
    out = []
    for joint, seen in values.items():
        if counts[joint] < FEWEST or len(seen) > 2 or (len(seen) == 2 and 0.0 not in seen):
            continue
        o, told = where[joint][0], " or ".join(f"{value:g}" for value in sorted(seen))
        sentence = (
            f"the effort of {joint} is {told} {effort_unit(o, o.joints.index(joint))} in all {counts[joint]} readings "
            "while its servo moves it: a flag, or a field that nothing fills; expected the effort that was measured, "
            f"or none: {FIELD[o.holder]}"
        )
        runs = tuple(o.name for o in where[joint])
        out.append(Mistake("effort_size", "likely", (joint,), sentence, "recordings.effort", runs))
    return out
