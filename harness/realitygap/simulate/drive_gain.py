"""Drive gains that a scenario leaves to be fitted: effort per recorded unit, from motions that are followed.

By least squares, joint by joint over all runs, with the recorded unit as what is explained, so that its noise does no
harm: unit = effort/gain + what opposes the motion (dry and viscous friction, an offset, a rotor). Where runs carry
different payloads, their known weight alone is the scale: whatever mass and centre the robot's own links have is
explained beside it. Where all carry the same, the robot's own weight is the scale, as good as its model.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import erf

import numpy as np
from realitygap_engines import GRAVITY, State
from realitygap_engines.law.dynamics import Dynamics
from realitygap_engines.model.robot import Model

from realitygap.files.errors import InputError
from realitygap.recording import Recording
from realitygap.robot.plant import Plant
from realitygap.simulate.follow import Followed
from realitygap.trace.trace import Array

BLOCKS = 8
"""Parts of the time that are left out in turn: the scatter of the gains is their error (jackknife, Efron 1982)."""
LOOSE = 0.25
"""A gain whose 95 % interval is wider than this share of it, either way, is not told: whatever the efforts say would be
no surer. On the UR10e the second joint's is known to 12 %, and that of the first, which carries no weight, to 50 %."""


@dataclass(frozen=True)
class Weighed:
    """A run of which gains are told: its plant, its motion, where the base stands, and the recorded units (t, n)."""

    plant: Plant
    followed: Followed
    start: State
    recorded: Array


def drive_gains(runs: Sequence[Weighed], joints: Sequence[int]) -> tuple[Array, Array]:
    """The gains of these joints [N·m or N per recorded unit], and half of their 95 % intervals. Shapes (k,).

    Raises:
        InputError: for a joint whose gain the runs do not fix.
    """
    names = runs[0].plant.model.joint_names
    by_load = len({tuple(sorted(run.plant.payloads.items())) for run in runs}) > 1
    columns = [_columns(run, by_load) for run in runs]
    gains, errors = np.empty(len(joints)), np.empty(len(joints))
    for k, j in enumerate(joints):
        matrix = np.vstack([c[:, :, j].T for c in columns])
        target = np.concatenate([run.recorded[:, j] for run in runs])
        gains[k], errors[k] = _gain(matrix, target)
        if not (gains[k] > 0 and errors[k] <= LOOSE * gains[k]):
            raise InputError(
                f"recordings.effort.factor: the runs do not fix the drive gain of {names[j]} ({gains[k]:.3g} ± "
                f"{errors[k]:.2g}); expected a number for it, or a payload that only some of the runs carry"
            )
    return gains, errors


def with_gains(plant: Plant, recording: Recording, joints: Sequence[int], gains: Array) -> tuple[Plant, Recording]:
    """A plant and a recording whose effort at these joints is told with these gains."""
    effort = recording.trace.effort
    assert effort is not None
    factor = np.ones(effort.shape[1])
    factor[list(joints)] = gains
    plant = plant.copy()
    plant.drive["torque_constant"] *= factor
    plant.drive["current_factor"] *= factor
    return plant, replace(recording, trace=replace(recording.trace, effort=effort * factor))


def _gain(matrix: Array, target: Array) -> tuple[float, float]:
    """One over the first column's coefficient, and half of its 95 % interval."""
    known = np.isfinite(target)
    part = np.arange(len(target)) * BLOCKS // len(target)

    def fit(rows: Array) -> float:
        return float(np.linalg.lstsq(matrix[rows] * scale, target[rows], rcond=1e-9)[0][0] * scale[0])

    size = np.linalg.norm(matrix[known], axis=0)
    scale = np.where(size > 0, 1 / np.where(size > 0, size, 1.0), 0.0)
    whole = fit(known)
    if not whole > 0:
        return np.nan, np.nan
    parts = np.array([fit(known & (part != b)) for b in range(BLOCKS)])
    error = np.sqrt((BLOCKS - 1) * np.mean((parts - parts.mean()) ** 2))
    return 1 / whole, 1.96 * error / whole**2


def _columns(run: Weighed, by_load: bool) -> Array:
    """What explains the recorded unit of a run, the scale first. Shape (c, t, n)."""
    motion, model = run.followed.smoothed, run.plant.model
    _, v, a = motion.value
    turns = np.where(motion.error[1] > 0, v / np.maximum(motion.error[1], 1e-300) / np.sqrt(2.0), np.sign(v) * np.inf)
    opposing = [np.vectorize(erf)(turns), v, np.ones_like(v), a]
    loaded = _efforts(run, run.plant.loaded())
    if not by_load:
        return np.array([loaded, *opposing])
    own = _efforts(run, model)
    weights = [_efforts(run, _heavier(model, i, unit)) - own for i in range(1, len(model.links)) for unit in np.eye(4)]
    return np.array([loaded - own, *opposing, *weights])


def _efforts(run: Weighed, model: Model) -> Array:
    """What the motion takes. Shape (t, n)."""
    reading, v, a = run.followed.smoothed.value
    base = np.concatenate([run.start.base_position, run.start.base_quaternion, np.zeros(6)])
    position = reading + run.plant.drive["offset"]
    return Dynamics(model).inverse(position, v, a, base, np.array([0.0, 0.0, -GRAVITY]))


def _heavier(model: Model, index: int, unit: Array) -> Model:
    """The model with a kilogram more in a link's frame, or a first moment of 1 kg·m along one of its axes."""
    link = model.links[index]
    moment = link.mass * link.com + unit[1:]
    mass = link.mass + unit[0]
    com = moment / mass
    about = link.inertia + link.mass * _square(link.com) - mass * _square(com)  # the inertia in the frame stays
    links = [*model.links]
    links[index] = replace(link, mass=mass, com=com, inertia=about)
    return replace(model, links=tuple(links))


def _square(c: Array) -> Array:
    return np.asarray(c @ c * np.eye(3) - np.outer(c, c))
