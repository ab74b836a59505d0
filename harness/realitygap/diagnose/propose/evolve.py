"""Multisines that tell more: the best of those that were drawn are varied, and what is better is kept.

An evolution strategy (Rechenberg 1973): what a motion is worth has many local optima in the phases of its sines, and no
derivative where friction sticks.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from realitygap.diagnose.propose.design import Goal
from realitygap.diagnose.propose.excitation import Excitation
from realitygap.robot.drive import Array

GENERATIONS, KEPT, CHILDREN = 2, 2, 4
"""How often multisines are varied, how many of each condition are kept, and how many variations of each are tried."""

Part = tuple[Excitation, Array]
"""A motion of one segment, and its gram. Shape (c, c)."""


def evolved(
    parts: Sequence[Part],
    goal: Goal,
    told: Callable[[list[Excitation]], list[Part]],
    random: np.random.Generator,
) -> list[Part]:
    """Variations of the best multisines that are better than those.

    Args:
        parts: what was tried.
        goal: what motions are worth.
        told: the parts of further motions, without those that leave a limit.
        random: draws variations.
    """
    best: dict[int, list[Part]] = {}
    for part in parts:
        if part[0].segments[0].wave is not None:
            best.setdefault(id(part[0].condition), []).append(part)
    old, count = {id(motion) for motion, _ in parts}, 0
    for _ in range(GENERATIONS if best else 0):
        best = {c: sorted(here, key=lambda p: -goal(p[1]))[:KEPT] for c, here in best.items()}
        parents = [motion for here in best.values() for motion, _ in here for _ in range(CHILDREN)]
        children = [_varied(m, count + k + 1, random) for k, m in enumerate(parents)]
        count += len(children)
        for part in told(children):
            best[id(part[0].condition)].append(part)
    kept = [p for here in best.values() for p in sorted(here, key=lambda p: -goal(p[1]))[:KEPT]]
    return [p for p in kept if id(p[0]) not in old]


def _varied(motion: Excitation, number: int, random: np.random.Generator) -> Excitation:
    (segment,) = motion.segments
    assert segment.wave is not None
    made = segment.maker.multisine(segment.wave.varied(random), f"fitted multisine {number}")
    return replace(motion, name=f"multisine_fitted_{number}", segments=(made,))
