"""What a motion tells of the effort that is missing, and the inertia that turns accelerations into efforts."""

from dataclasses import dataclass

import numpy as np
from realitygap_engines import State
from realitygap_engines.law.dynamics import Dynamics

from realitygap.robot.plant import Plant
from realitygap.trace.trace import Array


@dataclass(frozen=True)
class Lacking:
    """What a motion tells at its stamps. Shapes (t, n).

    Attributes:
        position, velocity: readings, smoothed [rad, rad/s or m].
        effort: that is missing on the joint [N·m or N].
        error: its standard error.
        load: what moving the links takes: gravity and inertia, without the rotors.
    """

    position: Array
    velocity: Array
    effort: Array
    error: Array
    load: Array


def inertias(plant: Plant, start: State, position: Array) -> Array:
    """The joint-space inertia of the links at readings (t, n), of a fixed base. Shape (t, n, n)."""
    n = position.shape[1]
    dynamics, out = Dynamics(plant.loaded()), np.empty((len(position), n, n))
    base, still = np.concatenate([start.base_position, start.base_quaternion, np.zeros(6)]), np.zeros(n)
    for k, q in enumerate(position + plant.drive["offset"]):
        dynamics.update(q, still, base, np.zeros(3))
        out[k] = dynamics.inertia
    return out


def times(matrix: Array, vector: Array) -> Array:
    """Products of matrices (t, n, n) and vectors (t, n)."""
    return np.asarray(np.einsum("tij,tj->ti", matrix, vector))
