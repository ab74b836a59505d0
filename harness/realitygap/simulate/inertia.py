"""The inertia that turns accelerations of joints into efforts."""

import numpy as np
from realitygap_engines import State
from realitygap_engines.law.dynamics import Dynamics

from realitygap.robot.plant import Plant
from realitygap.trace.trace import Array


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
