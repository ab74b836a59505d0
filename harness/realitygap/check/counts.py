"""Angles that are in no unit of angle: the counts of an encoder, as a servo's register holds them."""

import numpy as np
from realitygap_engines.model.robot import Joint

from realitygap.check.mistake import Mistake
from realitygap.check.observed import Observed
from realitygap.trace.trace import Array

DISTINCT = 10
"""So many different readings that are all whole numbers reach over 9 rad in steps of 1 rad: no encoder is so coarse."""
BEYOND = 100.0
"""rad: the middle of the coarsest servo's counts (512 of 1024) lies five times as far; a zero that is a turn off, or
several, does not."""
COUNTS = 4096
"""Of a turn: the usual magnetic encoder's 12 bits (Dynamixel X, Feetech STS)."""
TURN = 2.0 * np.pi
PER_RAD = COUNTS / TURN


def count_mistakes(o: Observed) -> list[Mistake]:
    """Positions or commands of joints that turn, of whole numbers that are no degrees."""
    found = {"position": o.recording.trace.position}
    if o.recording.command_kind == "position":
        found["command"] = o.recording.command
    out = []
    for j, joint in enumerate(o.plant.model.joints):
        known = {s: v[np.isfinite(v[:, j]), j] for s, v in found.items() if v is not None and not joint.prismatic}
        whole = {s: v for s, v in known.items() if _whole(v) and not _in_degrees(joint, v)}
        if whole:
            low, high = min(v.min() for v in whole.values()), max(v.max() for v in whole.values())
            what = f"the {' and the '.join(whole)} of {joint.name}"
            plural = len(whole) > 1
            told = f"{what} {'are' if plural else 'is'} of whole numbers alone, from {low:.0f} to {high:.0f}"
            out.append(count_mistake(o, j, told, next(iter(whole))))
    return out


def far_beyond(o: Observed, j: int) -> bool:
    """Whether half of a joint's positions, at least, lie further beyond its limits than turns explain."""
    q, joint = o.position[:, j], o.plant.model.joints[j]
    return bool(np.nanmedian(np.maximum(q - joint.upper, joint.lower - q)) > BEYOND)


def count_mistake(o: Observed, j: int, told: str, signal: str) -> Mistake:
    """The mistake of a joint of whose signal this is told."""
    sentence = (
        f"{told}: no angles in rad, as of encoder counts; expected rad: convert the recording, as by "
        f"(counts - {COUNTS // 2}) * 2π / {COUNTS} where {COUNTS} make a turn and the middle is the URDF's zero"
    )
    return Mistake("counts", "certain", (o.joints[j],), sentence, o.line(signal), (o.name,))


def _whole(value: Array) -> bool:
    return bool((value == np.round(value)).all()) and len(np.unique(value)) >= DISTINCT


def _in_degrees(joint: Joint, value: Array) -> bool:
    """Whether as degrees they are within a turn either way, or as far as the limits go."""
    ends = [abs(x) for x in (joint.lower, joint.upper) if np.isfinite(x)]
    return bool(np.abs(np.deg2rad(value)).max() <= max(TURN, *ends))
