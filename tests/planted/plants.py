"""The plants of a case: the perfect model's, and those with what is planted, sized until the recordings show it."""

from dataclasses import dataclass, field, replace
from typing import Any

import motions
import numpy as np
import planted
from foreign import Foreign, Motion, simulate
from imperfections import imperfect
from motions import Command
from outside import OUTSIDE
from planted import Planted
from recorder import Sensing, reported_effort, reported_velocity
from robots import Robot

VISIBLE = 4.0
"""A single effect moves the recordings by at least this, in root mean square over the noise."""

BLOWN_UP = 1e100
"""No motion is as large; squares of larger ones are no numbers any more."""


@dataclass
class Run:
    """One recorded motion; `swing` is how far it goes, as a share of the usual."""

    motion: str
    use: str
    seed: int
    length: float
    repetitions: int = 1
    gain: float = 1.0
    load: float = 1.0
    swing: float = 1.0
    sent: list[Command] = field(default_factory=list)


@dataclass(frozen=True)
class Truth:
    """One effect to plant: at a joint (its index) or, where `joint` is None, with one value at every joint."""

    effect: str
    joint: int | None
    size: float
    seed: int


@dataclass(frozen=True)
class Hidden:
    """All that the team does not know; draws are the same in every run.

    Attributes:
        truths: effects of the list.
        outside: what no effect explains: name, joint and seed.
        nearly: the seed of what keeps the laws nearly right; None where they are exact.
    """

    truths: tuple[Truth, ...] = ()
    outside: tuple[str, int, int] | None = None
    nearly: int | None = None

    def plant(self, robot: Robot, run: Run) -> tuple[Foreign, list[Planted], dict[str, Any] | None]:
        """The plant of one run, what was planted, and what is outside the list."""
        out = robot.plant(run.gain, run.load)
        told = [
            planted.plant(t.effect, out, robot, t.joint, t.size, np.random.default_rng(t.seed))
            if t.joint is not None
            else planted.plant_everywhere(t.effect, out, robot, t.size, t.seed)
            for t in self.truths
        ]
        other = None
        if self.outside:
            name, joint, seed = self.outside
            other = OUTSIDE[name](out, robot, joint, np.random.default_rng(seed))
        if self.nearly is not None:
            imperfect(out, robot, self.nearly)
        robot.bristles(out)
        return out, told, other


PERFECT = Hidden()


def command(robot: Robot, run: Run, sensing: Sensing) -> Command:
    """What is sent in one run."""
    reach = run.swing * robot.reach
    return motions.command(run.motion, len(robot.joints), reach, sensing.rate, run.length, run.seed)


def perform(plant: Foreign, run: Run, sent: Command, noise: np.ndarray | None = None) -> Motion:
    """One run of a plant, from rest at the first command."""
    return simulate(plant, sent.time, sent.value, sent.enabled, sent.value[0].copy(), run.length, noise)


def moved(robot: Robot, run: Run, hidden: Hidden, sensing: Sensing) -> tuple[Foreign, Motion]:
    """One run without noise, and its plant."""
    plant = hidden.plant(robot, run)[0]
    return plant, perform(plant, run, command(robot, run, sensing))


def measure(robot: Robot, runs: list[Run], sensing: Sensing) -> list[Motion]:
    """Simulate the perfect model; sets the robot's typical torque and speed."""
    n = len(robot.joints)
    robot.torque, robot.speed, robot.peak, robot.fastest = np.ones(n), np.ones(n), np.ones(n), np.ones(n)
    clean = [moved(robot, run, PERFECT, sensing)[1] for run in runs]
    moving = [(m.effort, m.velocity) for m, r in zip(clean, runs, strict=True) if r.motion != "lift_and_drop"]
    effort, velocity = (np.concatenate(x) for x in zip(*moving, strict=True))
    robot.torque, robot.speed = np.sqrt(np.mean(effort**2, axis=0)), np.sqrt(np.mean(velocity**2, axis=0))
    robot.peak, robot.fastest = np.max(np.abs(effort), axis=0), np.max(np.abs(velocity), axis=0)
    return clean


def visibility(robot: Robot, plant: Foreign, motion: Motion, clean: Motion, sensing: Sensing) -> float:
    """How far an effect moves one recording: root mean square over the sensor's noise.

    Of a plant that blew up it is infinite, or NaN where its motion is none any more, which shows nothing; either way
    `sane` draws the case anew.
    """
    farthest = float(np.abs([motion.reading, motion.velocity, motion.effort]).max())
    if not farthest < BLOWN_UP:
        return farthest * np.inf
    sigma = np.hypot(sensing.position_noise, 0.29) * sensing.quantum
    parts = [(motion.reading - clean.reading) / sigma]
    speed = reported_velocity(plant, motion)[::5] - clean.velocity[::5]
    parts.append(speed / (1.04 * sensing.velocity_noise * robot.speed))
    if sensing.effort:
        parts.append((reported_effort(plant, motion) - clean.effort) / (sensing.effort_noise * robot.torque))
    return max(float(np.sqrt(np.mean(np.square(x), axis=0)).max()) for x in parts)


def limits(robot: Robot, runs: list[Run], clean: list[Motion], sensing: Sensing, nearly: int | None) -> list[float]:
    """How visible a truth has to be in each run: over the noise, and no less than what keeps the laws nearly right.

    Where a truth moves every recording less than that, it is not what is missing from the model.
    """
    if nearly is None:
        return [VISIBLE] * len(runs)
    loud, hidden = replace(sensing, effort=True), Hidden(nearly=nearly)
    return [
        max(VISIBLE, visibility(robot, *moved(robot, run, hidden, sensing), base, loud))
        for run, base in zip(runs, clean, strict=True)
    ]


def sized(
    truth: Truth, robot: Robot, runs: list[Run], clean: list[Motion], sensing: Sensing, least: list[float]
) -> tuple[Truth, bool]:
    """A truth made larger until one run shows it, and whether one does."""
    loud = replace(sensing, effort=True)
    for _ in range(6):
        for run, base, enough in zip(runs, clean, least, strict=True):
            if visibility(robot, *moved(robot, run, Hidden((truth,)), sensing), base, loud) > enough:
                return truth, True
        truth = replace(truth, size=1.4 * truth.size)
    return replace(truth, size=truth.size / 1.4), False


def sane(robot: Robot, runs: list[Run], hidden: Hidden, sensing: Sensing) -> bool:
    """Whether every motion stays within the joint's range."""
    readings = [moved(robot, run, hidden, sensing)[1].reading for run in runs]
    return all(np.all(np.isfinite(x)) and np.abs(x).max() < 3.0 for x in readings)
