"""How a motion begins, and whether it is commanded at all."""

import numpy as np

from realitygap.check.mistake import Mistake
from realitygap.check.motion import MOVES, QUANTA, SLIDES
from realitygap.check.observed import Observed
from realitygap.check.words import joined, unit, wide

FAR, FAR_SLIDE = 0.35, 0.05
"""rad (20°) and m: a robot that holds its first command sags less."""
UNUSUAL = 4.0
"""A first error counts as far beyond so many times the motion's median error: weak servos lag that much all along."""
LATE, BEGUN = 0.3, 0.05
"""A servo that is told to go far has gone a twentieth of the way by then [s]: later than any delay on a bus."""
RISES = 0.5
"""A joint that goes from rest goes slower at first than this share of its fastest: one that is brought to its place
goes fastest at first; under a constant torque the first of two readings sees a third of what the second one does."""
SWINGS = 3
"""A joint that crosses the middle of its range more often is moved; less, it sags or falls."""


def start_mistakes(o: Observed) -> list[Mistake]:
    """A first position far from the first command, or a stated start far from the first position."""
    out = []
    first = o.recording.trace.position
    if first is None:
        return []
    told, seen = wide(o.command), wide(o.position)
    for j, joint in enumerate(o.joints):
        far = max(FAR_SLIDE, 0.5 * told[j]) if o.prismatic(j) else FAR
        on = np.isfinite(o.command[:, j])
        begun = bool(len(on)) and bool(on[0]) and bool(o.follows[j])
        error = o.command[on, j] - o.position[on, j]
        strays = begun and abs(error[0]) > far and abs(error[0]) > UNUSUAL * np.median(np.abs(error))
        if strays and not _steps(o, j, float(error[0])):
            sentence = (
                f"the motion of {joint} begins {abs(error[0]):.3g} {unit(o, j)} from its first command, and is usually "
                f"{np.median(np.abs(error)):.2g} {unit(o, j)} from it; expected a robot that holds its first command, "
                "or a recording that begins later"
            )
            out.append(Mistake("far_start", "likely", (joint,), sentence, f"{o.key}.path", (o.name,)))
    wanted = o.scenario.robot.start
    if not isinstance(wanted, dict) and wanted != "zero":
        return out
    for j, joint in enumerate(o.joints):
        stated = wanted.get(joint, 0.0) if isinstance(wanted, dict) else 0.0
        away = abs(float(first[0, j]) - stated)
        if away > (FAR_SLIDE if o.prismatic(j) else FAR) and seen[j] < 100 * FAR:
            sentence = (
                f"the simulation starts with {joint} at {stated:.3g} {unit(o, j)} and was measured to start at "
                f"{first[0, j]:.3g}; expected `start: recording`"
            )
            out.append(Mistake("far_start", "likely", (joint,), sentence, "robot.start", (o.name,)))
    return out


def _steps(o: Observed, j: int, error: float) -> bool:
    """Whether a motion is the answer to a first command that is a step: from rest, at once, and to there."""
    way = np.sign(error) * (o.position[:, j] - o.position[0, j])
    speed = np.diff(way)
    soon = way[o.clock <= o.clock[0] + LATE].max()
    return bool(len(speed) and speed[0] < RISES * speed.max() and soon > BEGUN * abs(error))


def constant_command(o: Observed) -> list[Mistake]:
    """Joints that are moved to and fro while their command never changes."""
    told, seen = wide(o.command), wide(o.position)
    names = []
    for j in map(int, np.flatnonzero(o.follows & np.isfinite(o.command).all(axis=0))):
        least = SLIDES if o.prismatic(j) else MOVES
        if told[j] <= 1e-3 * seen[j] and seen[j] > max(least, QUANTA * o.quantum[j]) and swings(o, j) >= SWINGS:
            names.append(o.joints[j])
    if not names:
        return []
    moved = joined([f"{seen[o.joints.index(n)]:.2g} {unit(o, o.joints.index(n))}" for n in names])
    sentence = (
        f"the command of {joined(names)} never changes, and the position moves to and fro over {moved}; expected the "
        "commands of this motion"
    )
    return [Mistake("constant_command", "likely", tuple(sorted(names)), sentence, "motion.recorded", (o.name,))]


def swings(o: Observed, j: int) -> int:
    """How often a position crosses from the lowest to the highest quarter of its range or back."""
    q = o.position[:, j]
    low, high = q.min() + 0.25 * np.ptp(q), q.max() - 0.25 * np.ptp(q)
    side = np.where(q < low, -1, np.where(q > high, 1, 0))
    side = side[side != 0]
    return int(np.sum(side[1:] != side[:-1]))
