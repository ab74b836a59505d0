"""The Jacobian of a fit by finite differences along its principal axes.

Contacts, play and sticking make simulated motions rough: two that differ by nothing that counts differ by some
deviations of the noise. Where values stand in for each other, as a gain for friction, each of them alone does much and
all of them together little; a difference of what two of them do alone is then mostly roughness, and a fit stops
anywhere in that valley. So values are moved together, along the axes of their common covariance (the right singular
vectors of the whitened Jacobian), as far as shows.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.fit.motions import Motions
from realitygap.diagnose.fit.responses import own_joint, single
from realitygap.diagnose.fit.space import Space
from realitygap.diagnose.likelihood.metric import Metric
from realitygap.diagnose.likelihood.whitening import Channel
from realitygap.robot.drive import Array

LONG = 16.0
"""How much an axis is to change the residual, in the metric, for its difference to be a slope. Where values differ by a
hundred-thousandth, the residual of a humanoid that kicks and whose shoulders have play differs by 1 to 4, that of an
arm with six joints by 1 to 5. Ten fits of the humanoid that began up to 40 % away ended between 20424 and 20646 in
evidence by single differences, and between 20628 and 20659 by these; of the arm 8 and 32 led no further than 16."""
FURTHEST = 0.5
"""How far an axis is followed at most, in multiples of a value, or of its size where that is more."""
SAME = 1e-3
"""Axes that are bent back by bounds to less than this part of another tell nothing of their own."""


@dataclass(frozen=True)
class _Block:
    """Values whose axes are common: all of them, or those of one joint, which its own samples tell.

    Attributes:
        values: their numbers.
        inside: the samples; None for all. Shape (m,), of bool.
        moves: a move of all values along every axis. Shape (axes, p).
    """

    values: list[int]
    inside: NDArray[np.bool_] | None
    moves: Array


def along_axes(
    motions: Motions,
    space: Space,
    x: Array,
    residual: Array,
    slopes: Array,
    metric: Metric,
    own: Sequence[Channel] | None = None,
) -> Array:
    """The Jacobian of the stacked residual per scaled value, by differences along the principal axes of a known one.

    Args:
        motions: that are simulated.
        space: of the values.
        x: where. Shape (p,).
        residual: there. Shape (m,).
        slopes: known from near by. Shape (m, p).
        metric: of the residual.
        own: the channels of the residual, where what single joints do is told by their own samples, all joints at once
            (`fit.slope`).

    Returns:
        Shape (m, p); what could not be simulated is as it was known.
    """
    unit = space.unit(x)
    white = space.with_prior(x, metric(np.column_stack([slopes * unit, residual])), unit)
    blocks = [
        _Block(values, inside, _moves(space, x, white[:, [*values, -1]], values))
        for values, inside in _blocks(motions.problem, space, own)
    ]
    together = [b for b in blocks if b.inside is not None]
    runs = [[(b, k)] for b in blocks if b.inside is None for k in range(len(b.moves))]
    most = max((len(b.moves) for b in together), default=0)
    runs += [[(b, k) for b in together if k < len(b.moves)] for k in range(most)]
    moved = [x + np.sum([b.moves[k] for b, k in run], axis=0) for run in runs]
    still, *answers = motions.residuals([space.at(y) for y in [x, *moved]])
    if still is None:
        return slopes
    out = slopes.copy()
    for block in blocks:
        told = [
            (block.moves[k], np.nan_to_num(answer - still))
            for run, answer in zip(runs, answers, strict=True)
            for b, k in run
            if b is block and answer is not None
        ]
        if told:
            v = block.values
            steps = np.column_stack([move[v] for move, _ in told])
            change = np.column_stack([change for _, change in told]) - slopes[:, v] @ steps
            change = change if block.inside is None else np.where(block.inside[:, None], change, 0.0)
            out[:, v] += change @ np.linalg.pinv(steps / unit[v][:, None], rcond=SAME) / unit[v]
    return out


def _blocks(
    problem: Problem, space: Space, own: Sequence[Channel] | None
) -> list[tuple[list[int], NDArray[np.bool_] | None]]:
    """The numbers of the values whose axes are common, and the samples that tell of them."""
    if own is None:
        return [(list(range(len(space.names))), None)]
    joints: dict[int, list[int]] = {}
    others: list[list[int]] = []
    for k, (i, _) in enumerate(space.names):
        suspect = space.changes[i].suspect
        if single(suspect):
            joints.setdefault(suspect.indices[0], []).append(k)
        else:
            others.append([k])
    at_joints = [(values, own_joint(problem, own, joint)) for joint, values in joints.items()]
    return [*((values, None) for values in others), *at_joints]


def _moves(space: Space, x: Array, white: Array, values: Sequence[int]) -> Array:
    """A move along every principal axis of some values, downhill, as far as shows. Shape (axes, p).

    Far enough for the residual to change by `LONG`, as the singular value of the axis tells.

    Args:
        space: of all values.
        x: where.
        white: whitened Jacobian per step of each of these values, and the residual. Shape (r, n + 1).
        values: their numbers.
    """
    v = np.array(values)
    low, high = (bound[v] for bound in space.bounds())
    at, unit = x[v], space.unit(x)[v]
    furthest = FURTHEST * np.maximum(np.abs(at), 1.0) / unit
    triangle = np.asarray(np.linalg.qr(white, mode="r"))
    downhill = -triangle[:, :-1].T @ triangle[:, -1]
    _, length, axes = np.linalg.svd(triangle[:, :-1], full_matrices=False)
    moves = np.zeros((len(axes), len(x)))
    for k, (size, axis) in enumerate(zip(length.tolist(), axes, strict=True)):
        bound = float(np.min(furthest / np.maximum(np.abs(axis), SAME)))
        far = min(max(LONG / max(size, SAME), 1.0), bound) * unit * (axis if axis @ downhill >= 0.0 else -axis)
        there, back = (np.clip(at + step, low, high) - at for step in (far, -far))
        moves[k, v] = there if np.linalg.norm(there / unit) >= 0.5 * np.linalg.norm(far / unit) else back
    return moves
