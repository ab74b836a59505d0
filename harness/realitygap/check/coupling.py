"""Joints that mimic others in the robot's file, and were measured elsewhere than that says."""

import numpy as np
from realitygap_engines.model.robot import Mimic

from realitygap.check.mistake import Mistake
from realitygap.check.motion import MOVES, SLIDES
from realitygap.check.observed import Mask, Observed
from realitygap.check.words import unit, wide
from realitygap.trace.trace import Array

USUAL = 0.95
"""Of the readings, which so far from the coupling break it: play, give and a moment of contact are no other one."""
BROKEN = 0.2
"""The share of the wider motion, the measured or the one by the coupling, that no play of a gripper's linkage is."""
FITS = 0.98
"""The share of a motion that another multiplier and offset explain where they are the coupling."""


def coupling_mistakes(o: Observed, judged: Mask) -> list[Mistake]:
    """Positions of joints (n,) that mimic others and do not keep to that; the simulated ones do."""
    out = []
    for name, mimic in o.plant.model.mimics.items():
        if name not in o.joints or mimic.joint not in o.joints:
            continue
        j, leader = o.joints.index(name), o.joints.index(mimic.joint)
        if not (judged[j] and judged[leader]):
            continue
        measured, led = o.position[:, j], o.position[:, leader]
        told = mimic.multiplier * led + mimic.offset
        away = float(np.nanquantile(np.abs(measured - told), USUAL))
        size = float(wide(np.column_stack([measured, told])).max())
        if away <= max(SLIDES if o.prismatic(j) else MOVES, BROKEN * size):
            continue
        rad = unit(o, j)
        sentence = (
            f"{name} is {_told(mimic)} in the robot's file, and was measured {away:.3g} {rad} and more away from that "
            f"for {1 - USUAL:.0%} of the time, of a motion of {size:.3g} {rad}{_fitting(measured, led, mimic)}; "
            "expected readings that keep to it: remove `mimic` where the joint moves by itself, or mend its multiplier "
            "and offset"
        )
        out.append(Mistake("coupling", "likely", (name,), sentence, "robot.urdf", (o.name,)))
    return out


def _told(mimic: Mimic) -> str:
    """A coupling in words."""
    return f"{mimic.multiplier:.3g} times {mimic.joint}{f' plus {mimic.offset:.3g}' if mimic.offset else ''}"


def _fitting(measured: Array, led: Array, mimic: Mimic) -> str:
    """The coupling that the readings (k,) keep to; "" where they keep to none."""
    known = np.isfinite(measured) & np.isfinite(led)
    measured, led = measured[known], led[known]
    if not np.ptp(led) or not np.ptp(measured):
        return ""
    share = float(np.corrcoef(led, measured)[0, 1] ** 2)
    multiplier, offset = np.polyfit(led, measured, 1)
    fits = f" ({_told(Mimic(mimic.joint, float(multiplier), float(offset)))} explains {share:.1%})"
    return fits if share > FITS else ""
