"""A point on a rod as a foreign plant, free or held: closed forms are known for both."""

import numpy as np
from chain import GRAVITY, Chain
from drivetrain import drives
from foreign import Foreign, Motion, simulate

INERTIA, MASS, LENGTH, ARMATURE = 0.004, 0.5, 0.2, 0.01
SWING = INERTIA + MASS * LENGTH**2


def pendulum(gravity: float = GRAVITY, **drive: float) -> Foreign:
    """A point on a rod; q = 0 hangs down."""
    chain = Chain(
        np.array([False]),
        np.array([[0.0, 1.0, 0.0]]),
        np.zeros((1, 3)),
        np.eye(3)[None],
        np.array([MASS]),
        np.array([[0.0, 0.0, -LENGTH]]),
        np.diag([INERTIA] * 3)[None],
        np.array([0.0, 0.0, -gravity]),
    )
    out = drives(1)
    out["armature"] = ARMATURE
    for key, value in drive.items():
        out[key] = value
    out["static"] = np.maximum(out["static"], out["coulomb"])
    out["bristle"] = out["static"] / 3e-4
    out["bristle_damping"] = np.sqrt(out["bristle"] * ARMATURE)
    return Foreign(chain, out)


def free(plant: Foreign, start: float, duration: float) -> Motion:
    """The servo is off from the beginning."""
    n = plant.n()
    return simulate(plant, np.zeros(1), np.zeros((1, n)), np.zeros(1), np.full(n, start), duration, settle=0.0)


def crossings(time: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Times at which x passes zero upwards."""
    k = np.flatnonzero((x[:-1] < 0) & (x[1:] >= 0))
    return np.asarray(time[k] - x[k] * (time[k + 1] - time[k]) / (x[k + 1] - x[k]))


HELD = {"gravity": 0.0, "coulomb": 50.0, "gain": 1.0, "torque_constant": 2.0, "resistance": 4.0, "supply": 10.0}
"""A joint that does not move, with 5 N·m at full duty."""


def held(error: float, duration: float = 0.1, **drive: float) -> tuple[np.ndarray, np.ndarray]:
    """The effort of a servo against a stuck joint, at a constant error. Shape (t,)."""
    plant = pendulum(**{**HELD, **drive})
    motion = simulate(plant, np.zeros(1), np.full((1, 1), error), np.ones(1), np.zeros(1), duration, settle=0.0)
    return motion.time, motion.effort[:, 0]
