"""The pool of a design: single segments under every condition, and the motions that are made of them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import product
from typing import get_args

import numpy as np

from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.propose.condition import conditions
from realitygap.diagnose.propose.design import Goal, chosen
from realitygap.diagnose.propose.evolve import Part
from realitygap.diagnose.propose.excitation import Excitation, period_of
from realitygap.diagnose.propose.explanations import Open
from realitygap.diagnose.propose.proposal import Proposal
from realitygap.diagnose.propose.safe import Tried, asks_beyond, left_in_engines
from realitygap.diagnose.propose.segments import Builder
from realitygap.diagnose.propose.telling import evenly
from realitygap.robot.drive import Array
from realitygap.scenario.propose import ProposeSpec, SegmentKind

Held = tuple[Excitation, tuple[str, ...], Array]
"""A motion, the engines in which it stays within the limits, and the gram of its segments. Shape (c, c)."""


PACES = (1.0, 0.5, 0.25)
"""Shares of the largest speed at which pieces are made, each where a faster one leaves a limit: against drag, speed
costs effort, of which no limit of speed says how much there is."""


TRIED = 4
"""Conditions under which motions are looked for, and one is looked at as a whole, at most: another gain, load and
supply beside the scenario's own. What tells most as if laws were exact need not be what tells most."""
ON_FEET = 2
"""The same of a robot on its feet: the scenario's own and the last that is listed. Pieces of four, each tried for its
footing, looked at under every explanation and varied, took a humanoid of 20 joints more than 20 minutes.
"""
ALIKE = 0.95
"""Directions of recorded motions with this cosine are one."""
SMALL = 0.02
"""A joint that goes this share of what another one goes is not moved with it."""


def builders(result: Proposal) -> list[Builder]:
    """Of the joints that are in question; of a robot on its feet, also of joints in step as in its recordings."""
    problem, n = result.problem, len(result.home)
    period, names = period_of(problem), labels(problem)
    ways = [(np.eye(n)[j], names[j]) for j in _joints(problem, result.open)]
    ways += [*in_step(problem, result.home)] if problem.plant.model.floating else []
    return [Builder(along, result.home, result.limits, period, name) for along, name in ways]


def in_step(problem: Problem, home: Array) -> Iterator[tuple[Array, str]]:
    """The direction that most of every recorded motion goes along, from a pose (n,), as far as they differ: what a
    robot has done on its feet it can do, where a joint alone would lift a foot. A unit of the way is that of the joint
    that goes farthest. Shape (n,) each, and what to call it.
    """
    known = list[Array]()
    for case in problem.cases:
        told = case.experiment.commands.value
        away = told[np.isfinite(told).all(axis=1)] - home
        if not np.any(away):
            continue
        along = np.linalg.svd(away, full_matrices=False)[2][0]
        if all(abs(along @ other) < ALIKE for other in known):
            known.append(along)
            far = np.where(np.abs(along) > SMALL * np.abs(along).max(), along, 0.0)
            yield far / far[np.argmax(np.abs(far))], f"all joints as in {case.experiment.name}"


Within = Callable[[list[Excitation]], list[Excitation]]
"""The motions that stay within the limits."""


def pool_of(result: Proposal, spec: ProposeSpec, inside: Within | None = None) -> list[Excitation]:
    """Single segments of the joints that are in question, under every condition, that stay within the limits as they
    are simulated in the engine of the search; of a kind of which some do not, slower ones, too.

    Args:
        result: the proposal.
        spec: what the owner says.
        inside: tells which motions stay within the limits; None for `within`.
    """
    problem = result.problem
    period = period_of(problem)
    off = () if _may_release(problem, spec) else ("release",)
    kinds: list[SegmentKind] = [k for k in get_args(SegmentKind) if k not in (*spec.forbid, *off)]
    most = ON_FEET if problem.plant.model.floating else TRIED
    ways = list(product(builders(result), evenly(conditions(problem, spec), most)))
    out, todo = [list[Excitation]() for _ in ways], [kinds for _ in ways]
    for pace in PACES:
        tried = [
            [Excitation(s.kind, (s,), condition, period) for s in replace(builder, pace=pace).every(asked)]
            for (builder, condition), asked in zip(ways, todo, strict=True)
        ]
        every = [m for of in tried for m in of]
        good = {id(m) for m in (within(result, every) if inside is None else inside(every))}
        for k, of in enumerate(tried):
            out[k] += [m for m in of if id(m) in good]
            todo[k] = list(dict.fromkeys(m.segments[0].kind for m in of if id(m) not in good))
    return [replace(m, name=f"{m.name}_{k}") for k, m in enumerate(m for of in out for m in of)]


def stands(result: Proposal) -> bool:
    """Whether a robot is within the limits, and on its feet, in the pose where motions start and end."""
    builder = Builder(np.ones(len(result.home)), result.home, result.limits, period_of(result.problem))
    (condition, *_) = conditions(result.problem, ProposeSpec())
    return bool(within(result, [Excitation("stay", (builder.stay(),), condition, builder.period)]))


def within(result: Proposal, motions: Sequence[Excitation]) -> list[Excitation]:
    """The motions that stay within the limits in the named model and the engine of the search. Rivals fit the same
    recordings and move alike; they, and other engines, have their say about a motion as a whole.
    """
    problem, named = result.problem, result.open.explanations[:1]

    def good(motion: Excitation) -> bool:
        if asks_beyond(motion.value, result.limits):
            return False
        left, held = left_in_engines(problem, motion, named, [problem.engine], result.limits)
        return not left and bool(held)

    return [m for m in motions if good(m)]


def labels(problem: Problem) -> list[str]:
    """The names of joints in labels: none where there is one joint."""
    names = problem.plant.model.joint_names
    return list(names) if len(names) > 1 else [""]


def _may_release(problem: Problem, spec: ProposeSpec) -> bool:
    """Whether a servo may be off: as the owner says, or where it was in a recording."""
    if spec.release is not None:
        return spec.release
    return any(np.isnan(c.experiment.commands.value).any() for c in problem.cases)


def _joints(problem: Problem, open_: Open) -> list[int]:
    """The joints that questions are about, or else the findings: where effects sit, or what moves their links; all, of
    a shared one, but for a robot on its feet, which moves as a whole with all of them in step.
    """
    out = set[int]()
    everywhere = set() if problem.plant.model.floating else set(range(len(problem.plant.model.joints)))
    asked = [s for q in open_.questions for s in q.targets]
    for suspect in asked or [c.suspect for c in open_.explanations[0].fit.changes]:
        at = suspect.indices if suspect.kind.sits_at == "joint" else [i - 1 for i in suspect.indices]
        out |= everywhere if suspect.kind.sits_at in ("base", "ground") else set(at)
    return sorted(j for j in out if j >= 0)


def motions_of(
    result: Proposal,
    parts: Sequence[Part],
    goal: Goal,
    engines: Sequence[str],
    seconds: float,
    most: int,
    tried: Tried,
) -> Iterator[Held]:
    """The best motions, the most promising first, one for every condition before a second one; a second one does
    without the kind of segment that tells most in the first.

    Args:
        result: the proposal.
        parts: the segments that can be simulated and stay within the limits.
        goal: what motions are worth.
        engines: in which motions have to stay within the limits.
        seconds: that each may take.
        most: how many.
        tried: what comes of trying a motion.
    """
    table = _Table(parts, goal, seconds)
    todo = [table.best(k, frozenset(), frozenset()) for k in range(len(table.conditions))]
    given = 0
    while given < most and any(todo):
        _, motion, condition, without, bad, gram = max((t for t in todo if t is not None), key=lambda t: t[0])
        out, held = left_in_engines(result.problem, motion, result.open.explanations, engines, result.limits, tried)
        if not out:
            given += 1
            yield replace(motion, name=f"{motion.name}_{given}"), held, gram
            todo[condition] = table.best(condition, without | {motion.segments[0].kind}, bad)
        else:
            todo[condition] = table.best(condition, without, bad | {motion.segments[k].label for k in out})


def by_condition(parts: Sequence[Part]) -> list[tuple[list[Array], list[float]]]:
    """The grams and the seconds of the segments of every condition: a motion has one."""
    out: dict[int, tuple[list[Array], list[float]]] = {}
    for motion, gram in parts:
        grams, seconds = out.setdefault(id(motion.condition), ([], []))
        grams.append(gram)
        seconds.append(motion.seconds)
    return list(out.values())


Candidate = tuple[float, Excitation, int, frozenset[str], frozenset[str], Array]
"""A motion with its worth, the number of its condition, the kinds it does without, the labels of segments that leave a
limit, and the gram of its own.
"""
AGAIN = 100.0
"""A second motion under a condition comes after the first of every other that settles anything: so much less."""


class _Table:
    """What every segment tells, by condition."""

    def __init__(self, parts: Sequence[Part], goal: Goal, seconds: float) -> None:
        self.parts, self.goal, self.seconds = parts, goal, seconds
        self.conditions = list({id(m.condition): m.condition for m, _ in parts}.values())

    def best(self, condition: int, without: frozenset[str], bad: frozenset[str]) -> Candidate | None:
        """The best motion under a condition without some kinds and segments; None where none tells anything."""
        here = [
            (m, g)
            for m, g in self.parts
            if m.condition is self.conditions[condition]
            and m.segments[0].kind not in without
            and m.segments[0].label not in bad
        ]
        lengths, grams = [m.seconds for m, _ in here], [g for _, g in here]
        picked = chosen(self.goal, grams, lengths, self.seconds)
        if not picked:
            return None
        gram = np.sum([grams[i] for i in picked], axis=0)
        segments = tuple(here[i][0].segments[0] for i in picked)
        kinds = list(dict.fromkeys(s.kind for s in segments))
        motion = replace(here[0][0], segments=segments, name="_".join(kinds[:3]))
        return float(self.goal(gram)) - AGAIN * len(without), motion, condition, without, bad, gram
