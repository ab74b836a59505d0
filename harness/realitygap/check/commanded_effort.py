"""Commands of servos that are told efforts, beside the efforts that were measured: unit and sign.

A motor with a current controller gives what it is told, through a lag and a gain near 1.
"""

import numpy as np

from realitygap.check.effort import THOUSAND
from realitygap.check.follow import Following, following
from realitygap.check.mistake import Mistake
from realitygap.check.observed import Mask, Observed
from realitygap.check.words import effort_unit
from realitygap.robot.drive import TORQUE

FITS = 0.9
"""The share of an effort that its command explains where a unit or a sign is read off: 0.998 of motors with current
controllers."""
MOST = 5.0
"""Commanded and measured effort are within this factor of one another, whatever the gear's efficiency, friction and an
unknown torque constant are; units in use are 9.8 times apart or more."""


def commanded_efforts(o: Observed, judged: Mask) -> list[Mistake]:
    """Commanded efforts in another unit or with another sign than the measured ones, at the joints (n,) judged."""
    told = (o.plant.drive["kind"] == TORQUE) & (o.recording.command_kind == "effort")
    if o.effort is None or not (judged & told).any() or len(o.clock) < 50:
        return []
    chosen = [int(j) for j in np.flatnonzero(judged & told) if np.isfinite(o.effort[:, j]).all()]
    out = []
    for j in chosen:
        fit, _ = following(o.command[:, [j]], o.effort[:, [j]], o.step)
        if np.nan_to_num(fit.share[0, 0]) >= FITS and (found := _mistake(o, j, fit)) is not None:
            out.append(found)
    return out


def _mistake(o: Observed, j: int, fit: Following) -> Mistake | None:
    """What the slope of measured by commanded effort says; the gain of the servo is what it should be."""
    joint, unit, share = o.joints[j], effort_unit(o, j), fit.share[0, 0]
    times = float(fit.slope[0, 0] / o.plant.drive["gain"][j])
    larger = max(abs(times), 1.0 / abs(times))
    who = "measured" if abs(times) > 1.0 else "commanded"
    key = "recordings.effort" if who == "measured" else o.line("command")
    if larger > MOST:
        kind, word = "effort_size", "another unit, as it seems"
        if THOUSAND / MOST < larger < THOUSAND * MOST:
            kind, word = "milliamperes", f"a thousand times too large, as of m{unit} or of a current in mA"
        sentence = (
            f"the {who} effort of {joint} is {larger:.4g} times the {'commanded' if who == 'measured' else 'measured'} "
            f"one (explains {share:.1%}): {word}; expected {unit} of both: recordings.effort.factor is {unit} per "
            f"recorded unit, the servo's gain {unit} per commanded unit"
        )
    elif times < 0.0:
        kind, key = "flipped_sign", o.line("command")
        sentence = (
            f"the measured effort of {joint} goes against the commanded one: {times:.2f} times it (explains "
            f"{share:.1%}): the sign of one of them is flipped; expected both to count as the URDF's axis"
        )
    else:
        return None
    return Mistake(kind, "certain", (joint,), sentence, key, (o.name,))
