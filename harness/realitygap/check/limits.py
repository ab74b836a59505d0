"""Measured angles and the URDF's limits: which of them is in degrees."""

from dataclasses import replace

import numpy as np
from realitygap_engines.model.robot import Joint

from realitygap.check.counts import count_mistake, far_beyond
from realitygap.check.mistake import Certainty, Mistake
from realitygap.check.observed import Observed
from realitygap.check.servo import supply
from realitygap.check.words import FACTORS, wide
from realitygap.recording.turns import LEEWAY, within_limits, without_turns
from realitygap.robot.drive import DC
from realitygap.robot.plant import Plant
from realitygap.trace.trace import Array

DEGREES = FACTORS["degrees"]
TURN = 2.0 * np.pi
STATED = ", or `units: {position: deg}` under recordings.columns"
POSITION = {
    "bag": ("recordings.state", STATED),
    "table": ("recordings.columns.position", STATED),
    "data set": ("recordings.dataset.units", ", or `units: degrees` under recordings.dataset"),
}
"""Where a scenario says what positions are, and how it says degrees, by what holds them."""
TOO_FAST = 5.0
"""A joint is this much faster than its servo runs free only in another unit: loads drag it to twice that."""


def limit_mistakes(plant: Plant) -> list[Mistake]:
    """Limits of revolute joints beyond two turns, that are ordinary angles in degrees."""
    out = []
    for joint in plant.model.joints:
        low, high = joint.lower, joint.upper
        finite = np.isfinite(low) and np.isfinite(high) and not joint.prismatic
        if finite and max(abs(low), abs(high)) > 2 * TURN and max(abs(low), abs(high)) / DEGREES <= TURN + 1e-6:
            ordinary = all(abs(x - round(x)) < 1e-9 for x in (low, high))
            sentence = (
                f"the limits of {joint.name} are {low:.4g} and {high:.4g}, more than two turns in radians: degrees, as "
                "it seems; expected radians in the URDF"
            )
            certainty: Certainty = "certain" if ordinary and high - low > 4 * TURN else "likely"
            out.append(Mistake("degrees", certainty, (joint.name,), sentence, "robot.urdf"))
    return out


def angle_mistakes(o: Observed) -> list[Mistake]:
    """Measured angles that fit the limits, or the servo's speed, only when they are degrees, or no limits at all; or
    limits that are to blame.
    """
    out = []
    seen = wide(o.position)
    speed = np.gradient(o.position, o.step, axis=0)
    for j, joint in enumerate(o.plant.model.joints):
        if joint.prismatic:
            continue
        q, fast = o.position[:, j], float(np.quantile(np.abs(speed[:, j]), 0.95))
        free = _free_speed(o, j)
        beyond = _beyond(joint, q)
        turns, rad = _in_degrees(o, j)
        fits = _beyond(joint, rad) <= LEEWAY
        if fits and turns:
            told = f"jumps by 360 {turns} time{'s' * (turns > 1)}, as an angle that begins again after a turn"
        elif beyond > max(TURN, joint.upper - joint.lower) and fits:
            told = f"lies up to {beyond:.4g} rad beyond its limits {joint.lower:.4g} and {joint.upper:.4g}"
        elif fits and free < fast / TOO_FAST and fast / DEGREES < free and seen[j] > TURN / 2:
            told = f"moves at {fast:.4g} rad/s, and its servo at {free:.3g} rad/s at most"
        elif far_beyond(o, j):
            limits = f"its limits {joint.lower:.4g} and {joint.upper:.4g}, and as degrees, too"
            told = f"the position of {joint.name} lies up to {beyond:.4g} rad beyond {limits}"
            out.append(count_mistake(o, j, told, "position"))
            continue
        else:
            apart = joint.upper - joint.lower
            if seen[j] > 5.0 * apart and _beyond(_turned(joint), q) <= LEEWAY and seen[j] < TURN:
                sentence = (
                    f"{joint.name} was measured over {seen[j]:.3g} rad and its limits are {apart:.3g} rad apart: "
                    "limits divided by 57.3 once too often, as it seems; expected radians in the URDF"
                )
                out.append(Mistake("degrees", "likely", (joint.name,), sentence, "robot.urdf", (o.name,)))
            continue
        sentence = f"the position of {joint.name} {told}; divided by 57.3 it fits: degrees, as it seems; expected rad"
        key, or_say = POSITION[o.holder]
        out.append(Mistake("degrees", "certain", (joint.name,), sentence + or_say, key, (o.name,), "position"))
    return out


def _in_degrees(o: Observed, j: int) -> tuple[int, Array]:
    """A joint's positions (t,) as if they were in degrees [rad], with their turns counted, and how many of these are
    seen: as it is read, an angle in rad jumps by one and not by 57.
    """
    position, joint = o.recording.trace.position, o.plant.model.joints[j]
    assert position is not None
    smooth, turned, _ = without_turns(o.recording.trace.time, position[:, [j]] / DEGREES)
    limits = np.array([[joint.lower, joint.upper]])
    return len(turned[0]), within_limits(smooth, limits)[0][:, 0]


def _turned(joint: Joint) -> Joint:
    return replace(joint, lower=joint.lower * DEGREES, upper=joint.upper * DEGREES)


def _beyond(joint: Joint, q: Array) -> float:
    """How far positions pass the limits [rad]; 0 within."""
    return float(max(np.nanmax(q) - joint.upper, joint.lower - np.nanmin(q), 0.0))


def _free_speed(o: Observed, j: int) -> float:
    """The speed at which a servo gives nothing any more [rad/s]; inf where nothing says it."""
    d = o.plant.drive[j]
    if d["kind"] == DC:
        return float(supply(o)[j] * d["duty_limit"] / d["torque_constant"])
    return float(d["velocity_limit"]) if d["velocity_limit"] > 0 else np.inf
