"""Velocity limits that a joint was driven past: its servo keeps them in the simulation, as it did not in the robot."""

import numpy as np

from realitygap.check.mistake import Mistake
from realitygap.check.observed import Mask, Observed
from realitygap.check.words import unit
from realitygap.recording.noise import MOVED, own_noise
from realitygap.robot.drive import PID
from realitygap.trace.trace import Array

STEPS = 3
"""Of the even clock, one after another, that a speed holds: a reading that is off goes there and back."""
FASTER = 1.2
"""Of 1350 recordings of joints of planted robots that keep their limits, the fastest that was driven on went 1.035
times its limit; what a load or the rest of the robot dragged went up to 3.4 times it."""
DRIVEN = 0.1
"""The share of the largest effort of a joint, measured or needed, that drives it on rather than is noise."""


def speed_limit_mistakes(o: Observed, judged: Mask) -> list[Mistake]:
    """Velocity limits that servos of kind pid would keep, and that the joints (n,) that are judged were driven past.

    What is dragged past its limit tells nothing of it: the effort has to act along the motion, as it was measured, or
    else as moving the links of a fixed base takes it.
    """
    effort = _driving(o)
    if effort is None or len(o.clock) <= STEPS:
        return []
    speed = np.diff(o.position, axis=0) / o.step
    middle = 0.5 * (effort[1:] + effort[:-1])
    with np.errstate(invalid="ignore"):
        least = DRIVEN * np.nanmax(np.abs(effort), axis=0, initial=0.0)
        ways = [(_held(s * speed), _held(np.where(s * middle > least, s * speed, 0.0))) for s in (1.0, -1.0)]
    fastest, driven = (np.maximum(*pair) for pair in zip(*ways, strict=True))
    limit = o.plant.drive["velocity_limit"]
    noise = MOVED * np.sqrt(2.0) * own_noise(o.position) / o.step
    out = []
    for j in np.flatnonzero(judged & (o.plant.drive["kind"] == PID) & (driven > FASTER * limit + noise)):
        rate = f"{unit(o, int(j))}/s"
        sentence = (
            f"{o.joints[j]} was measured at {fastest[j]:.3g} {rate}, and still driven on at {driven[j]:.3g} {rate}; "
            f"its URDF's velocity limit is {limit[j]:.4g} {rate}, beyond which its pid servo drives nothing on in the "
            "simulation; expected a limit that the joint keeps: correct its `velocity` in the URDF"
        )
        out.append(Mistake("velocity_limit", "likely", (o.joints[j],), sentence, "robot.urdf", (o.name,)))
    return out


def _driving(o: Observed) -> Array | None:
    """The effort that drives every joint [N·m or N]: measured, or else needed; None where neither is known."""
    if o.effort is None:
        return None if o.plant.model.floating else o.needed_effort
    return o.effort


def _held(speed: Array) -> Array:
    """The largest speed that holds over `STEPS` steps, per column. Shape (k, n), gives (n,)."""
    windows = np.lib.stride_tricks.sliding_window_view(speed, STEPS, axis=0)
    return np.asarray(np.nan_to_num(windows.min(axis=-1), nan=0.0).max(axis=0, initial=0.0))
