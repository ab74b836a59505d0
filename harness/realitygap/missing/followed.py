"""The missing effort of joints that are followed: the model's effort along the measured motion less the measured one.

It is what would act on the joint beside the model, as friction does: against a motion that takes more than the model
says, it is negative.
"""

import numpy as np
from realitygap_engines import State

from realitygap.missing.lacking import Lacking
from realitygap.robot.plant import Plant
from realitygap.simulate.follow import Followed, reported, taken, unsure
from realitygap.trace.trace import Array


def lacking_followed(
    engine: str, plant: Plant, followed: Followed, start: State, measured: Array, *, of_joint: bool
) -> Lacking:
    """The missing effort where the effort (t, n) was measured along a motion; arguments as of `simulate.follow`.

    Raises:
        Unsupported: where the engine cannot express the plant.
    """
    found = taken(engine, plant, followed, start)
    motion = found.motion
    if of_joint:
        effort = found.joint - measured
    else:
        effort = found.motor - measured / reported(plant, motion.time - motion.time[0])
        effort = effort - np.clip(effort, -found.left, found.left)
    position, velocity, _ = motion.value
    spread = unsure(plant, found, start, of_joint=of_joint)
    return Lacking(position, velocity, effort, np.hypot(spread, _noise(measured)), found.load)


def _noise(measured: Array) -> Array:
    """The standard deviation of white noise on an effort, from its second differences. Shape (n,)."""
    bend = np.abs(np.diff(measured, n=2, axis=0))
    return np.asarray(1.4826 * np.nanmedian(bend, axis=0) / np.sqrt(6.0))
