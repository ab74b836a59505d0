"""What the drives of a model give while its joints are led along a known motion: the drive law without an engine.

Where a joint rests, its dry friction is not determined by the motion: it holds whatever it can. So friction is taken as
close as its bound allows to what the motion needs; in place of the sign of a velocity that is known with a standard
error stands its expected value, erf(v/(√2·error)), and what that leaves open of the bound is told beside it.
"""
# mypy: allow-untyped-defs
# (the compiled function takes arrays and numbers only; its caller is typed)

import math
from dataclasses import dataclass

import numpy as np
from realitygap_engines.law.compiled import compiled

from realitygap.robot.drive import LOG, STATE
from realitygap.robot.drive_law import drive_effort
from realitygap.robot.effort_map import packed
from realitygap.robot.law.effort_map import add_mapped
from realitygap.robot.plant import Plant
from realitygap.trace.trace import Array


@dataclass(frozen=True)
class Led:
    """Efforts on the joints over every step of a motion that they are led along.

    Attributes:
        smooth: of motor, springs, maps and all but dry friction [N·m or N]. Shape (steps, n).
        dry: of dry friction. Shape (steps, n).
        open: by how much dry friction could be more or less than that, as the joint is nearly at rest.
            Shape (steps, n).
    """

    smooth: Array
    dry: Array
    open: Array


def lead(
    plant: Plant,
    position: Array,
    velocity: Array,
    error: Array,
    need: Array,
    command: Array,
    volts: Array,
    h: float,
    integral: Array,
) -> Led:
    """Lead the joints of a plant along a motion.

    Args:
        plant: the robot with its drives.
        position: true positions at the times of the steps, k·h [rad or m]. Shape (steps, n).
        velocity: half a step before and half a step after each of them. Shape (steps + 1, n).
        error: standard error of the velocities. Shape (steps, n).
        need: what the motion takes of the joints altogether, with the rotors [N·m or N]. Shape (steps, n).
        command: of every servo over every step; NaN where it is off. Shape (steps, n).
        volts: the recorded supply [V]; 0 where there is none. Shape (steps,).
        h: the length of a step [s].
        integral: what PID servos have gathered at the beginning [N·m or N]. Shape (n,).
    """
    steps, n = position.shape
    state = np.zeros(n, STATE)
    state["velocity"], state["integral"] = velocity[0], integral
    out = Led(np.empty((steps, n)), np.empty((steps, n)), np.empty((steps, n)))
    maps, numbers = packed(plant.maps)
    _lead(
        plant.drive, maps, numbers, state, np.zeros(n, LOG), position, velocity, error, need, command, volts,
        plant.inertia(), h, out.smooth, out.dry, out.open,
    )  # fmt: skip
    out.smooth[:] += plant.given(np.asarray(np.arange(steps) * h, dtype=np.float64))
    return out


@compiled
def _lead(
    drive, maps, numbers, state, log, position, velocity, error, need, command, volts, inertia, h, smooth, dry, left
):
    steps, n = position.shape
    effort, damping, bound = np.zeros(n), np.zeros(n), np.zeros(n)
    before = np.zeros(n)
    for k in range(steps):
        t = k * h
        after = min(k + 1, steps - 1)
        drive_effort(
            drive, state, command[k], command[after], position[k], velocity[k], before, inertia, volts[k], t, h,
            effort, damping, bound, log,
        )  # fmt: skip
        if maps.size:
            add_mapped(
                maps, numbers, drive, state, command[k], velocity[k], inertia, volts[k], t, h, effort, damping, log
            )
        for j in range(n):
            v = 0.5 * (velocity[k, j] + velocity[k + 1, j])
            side = math.erf(v / (math.sqrt(2.0) * error[k, j])) if error[k, j] > 0.0 else np.sign(v)
            smooth[k, j] = effort[j] - damping[j] * velocity[k + 1, j]
            left[k, j] = bound[j] * (1.0 - abs(side))
            middle = -bound[j] * side
            dry[k, j] = min(max(need[k, j] - smooth[k, j], middle - left[k, j]), middle + left[k, j])
            before[j] = dry[k, j]
