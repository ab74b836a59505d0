"""A disturbing torque on one joint: what differs from one repetition of a motion to the next."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from realitygap.robot.drive import Array
from realitygap.robot.plant import Plant
from realitygap.simulate.experiment import Experiment
from realitygap.trace.first_order import first_order

CORRELATION = 0.15
"""Correlation time of what disturbs a joint, and of what a model leaves unexplained [s]: that of the residuals of the
recorded servos (0.1 to 0.25 s over the shared sets; a position loop of 1 to 2 Hz)."""


@dataclass(frozen=True)
class Push:
    """A torque [N·m or N] on a joint: constant, or with a `seed` a random one of that standard deviation."""

    joint: int
    torque: float
    seed: int | None = None

    def on(self, plant: Plant, experiment: Experiment) -> None:
        """Put it on a plant."""
        if self.seed is None:
            plant.drive["constant"][self.joint] += self.torque
            return
        h = experiment.scenario.timestep
        steps = int(experiment.duration / h) + 3
        torque = coloured(steps, h, self.seed) * self.torque
        plant.efforts.append(_Effort(torque, h, self.joint, len(plant.model.joints)))


@dataclass(frozen=True)
class _Effort:
    """A torque over time, as a joint effort of a plant."""

    torque: Array
    h: float
    joint: int
    count: int

    def __call__(self, time: Array) -> Array:
        out = np.zeros((len(time), self.count))
        out[:, self.joint] = self.torque[np.minimum(np.rint(time / self.h).astype(np.int64), len(self.torque) - 1)]
        return out


def coloured(steps: int, h: float, seed: int) -> Array:
    """Random numbers of unit variance and a correlation time, the same for the same seed. Shape (steps,)."""
    keep = np.exp(-h / CORRELATION)
    white = np.random.default_rng(seed).standard_normal(steps) * np.sqrt(1 - keep**2)
    return first_order(white, keep)
