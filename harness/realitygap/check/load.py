"""What moving a robot as it was measured takes, and whether its servos could have given that."""

from collections.abc import Sequence

import numpy as np

from realitygap.check.mistake import Certainty, Mistake
from realitygap.check.observed import Observed
from realitygap.check.servo import limit, stiffness
from realitygap.check.words import effort_unit
from realitygap.trace.trace import Array

HEAVY = 30.0
"""A robot that needs this many times more effort than its servos gave is not of that mass: gains and constants are off
by less than `WEAK`, and friction only adds to what they gave."""
LIGHT = 0.006
"""And one that needs this share of it or less, at all joints, is not either: gears of small arms take up to 30 times
what their links do, not 170."""


def load_mistakes(observed: Sequence[Observed]) -> list[Mistake]:
    """Masses that the servos could not have moved as measured, by a factor of a thousand; of robots that stand fixed.

    The effort that the measured motion needs (rigid bodies, no friction) beside the measured effort and beside what the
    servos made of the measured errors: it must contradict both, where there are both.
    """
    for o in observed:
        if o.plant.model.floating or len(o.clock) < 50:
            continue
        needed = np.sqrt(np.mean(o.needed_effort**2, axis=0))
        links = np.sqrt(np.mean(o.needed_by_links**2, axis=0))  # rotors are in no URDF
        told = np.array([_measured(o), _by_law(o)])
        known = np.isfinite(told) & (told > 0)
        if not known.any():
            continue
        most, least = np.where(known, told, -np.inf).max(axis=0), np.where(known, told, np.inf).min(axis=0)
        judged = known.any(axis=0)
        heavy = np.where(judged, needed / np.where(judged, most, 1.0), 0.0)
        light = np.where(judged, links / np.where(judged, least, 1.0), 0.0)
        if heavy.max() > HEAVY:
            j = int(np.argmax(heavy))
            return [_mistake(o, j, needed[j], most[j], "certain", "large, as of grams")]
        if judged.all() and light.max() < LIGHT:
            j = int(np.argmax(light))
            return [_mistake(o, j, links[j], least[j], "likely", "small")]
    return []


def _mistake(o: Observed, j: int, needed: float, given: float, certainty: Certainty, how: str) -> Mistake:
    unit = effort_unit(o, j)
    sentence = (
        f"moving {o.joints[j]} as measured takes {needed:.3g} {unit} (rms), and its servo gave about {given:.2g} "
        f"{unit}: masses or inertias a thousand times too {how}, as it seems; expected kg and kg·m²"
    )
    return Mistake("grams", certainty, _suspects(o), sentence, "robot.urdf", (o.name,))


def _measured(o: Observed) -> Array:
    """The rms of the measured effort; NaN where there is none. Shape (n,)."""
    if o.effort is None:
        return np.full(len(o.joints), np.nan)
    known = np.isfinite(o.effort)
    squares = np.where(known, o.effort, 0.0) ** 2
    return np.asarray(
        np.where(known.any(axis=0), np.sqrt(squares.sum(axis=0) / np.maximum(known.sum(axis=0), 1)), np.nan)
    )


def _by_law(o: Observed) -> Array:
    """What the servos gave, about: by their stiffness for the errors, within their limits. Shape (n,)."""
    error = np.nanquantile(np.where(np.isfinite(o.command), np.abs(o.command - o.position), 0.0), 0.9, axis=0)
    by_error = np.where(o.plant.drive["ki"] > 0, np.inf, stiffness(o) * error)
    law = np.where(o.follows, np.minimum(by_error, limit(o)), np.nan)
    return np.asarray(np.where(np.isfinite(law), law, np.nan))


def _suspects(o: Observed) -> tuple[str, ...]:
    """The joints that carry the link that is out of proportion, or else all joints."""
    masses = np.array([link.mass for link in o.plant.model.links[1:]])
    heaviest = int(np.argmax(masses))
    if len(masses) > 1 and masses[heaviest] > HEAVY * np.median(np.delete(masses, heaviest)):
        return (o.joints[heaviest],)
    return o.joints
