"""Responses: finite-difference sensitivities of the residual to a try of every suspect, at the model as it stands."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from realitygap.diagnose.candidates.starts import Start
from realitygap.diagnose.data.case import JOINT_SIGNALS
from realitygap.diagnose.data.changes import Change, Suspect, as_read
from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.fit.motions import Motions
from realitygap.diagnose.likelihood.whitening import Channel
from realitygap.robot.drive import Array

MANY_JOINTS = 2
"""With more joints than this, an effect is tried on all joints at once, and each joint's answer is its own: what one
joint does to another through the links is small beside it in a geared robot, and a try is later simulated alone."""


@dataclass(frozen=True)
class Block:
    """A start with its responses: the change of the stacked residual per unit of each try. Shape (m, tries)."""

    start: Start
    columns: Array

    @property
    def suspect(self) -> Suspect:
        """Whose responses they are."""
        return self.start.suspect


def respond(
    motions: Motions, accepted: Sequence[Change], tried: Sequence[Start], channels: Sequence[Channel]
) -> list[Block]:
    """The responses of starts to a model with accepted changes; starts that cannot be simulated are left out."""
    variants = _together(motions.problem, tried)
    models = [as_read([*accepted, *v.values()], accepted, motions.problem.plant) for v in variants]
    still, *answers = motions.residuals([accepted, *models])
    if still is None:
        return []
    masks: dict[int, NDArray[np.bool_]] = {}
    found: dict[tuple[int, int], Array] = {}
    for variant, answer in zip(variants, answers, strict=True):
        if answer is None:
            continue
        change = np.nan_to_num(answer - still)
        for (turn, number), try_ in variant.items():
            column = change
            if len(variant) > 1:
                (joint,) = try_.suspect.indices
                if joint not in masks:
                    masks[joint] = own_joint(motions.problem, channels, joint)
                column = np.where(masks[joint], change, 0.0)
            found[turn, number] = column / tried[turn].share
    out = []
    for i, start in enumerate(tried):
        columns = [found.get((i, k)) for k in range(len(start.tries))]
        good = [c for c in columns if c is not None]
        if good and len(good) == len(columns) and np.abs(good).max() > 0.0:
            out.append(Block(start, np.column_stack(good)))
    return out


def _together(problem: Problem, tried: Sequence[Start]) -> list[dict[tuple[int, int], Change]]:
    """What is simulated at once: with many joints the same try of one effect at all of them, otherwise each alone."""
    many = at_once(problem)
    out: list[dict[tuple[int, int], Change]] = []
    shared: dict[tuple[str, int, int], dict[tuple[int, int], Change]] = {}
    counts: dict[Suspect, int] = {}
    for i, start in enumerate(tried):
        turn = counts.setdefault(start.suspect, 0)
        counts[start.suspect] += 1
        for k in range(len(start.tries)):
            change = start.simulated(k)
            if many and single(start.suspect):
                shared.setdefault((start.suspect.effect, turn, k), {})[i, k] = change
            else:
                out.append({(i, k): change})
    return [*out, *shared.values()]


def at_once(problem: Problem) -> bool:
    """Whether the same try of one effect is simulated at all joints at once."""
    return int(problem.judged.sum()) > MANY_JOINTS


def single(suspect: Suspect) -> bool:
    """Whether it sits at one joint."""
    return suspect.kind.sits_at == "joint" and len(suspect.indices) == 1


def at_one_place(suspect: Suspect) -> bool:
    """Whether it does not hold for several joints at once."""
    return suspect.kind.sits_at != "joint" or single(suspect)


def own_joint(problem: Problem, channels: Iterable[Channel], joint: int) -> NDArray[np.bool_]:
    """Which stacked samples are those of one joint. Shape (m,), of bool."""
    judged = problem.judged
    column = int(np.sum(judged[:joint]))
    parts = [
        np.full(len(c.time), c.signal in JOINT_SIGNALS and c.column == column and bool(judged[joint])) for c in channels
    ]
    return np.concatenate(parts)
