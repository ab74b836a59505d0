"""Design: which segments, one behind the other, part the explanations most, within a length.

What segments tell adds up, because each starts and ends at rest in the same pose. The best are therefore added one
after the other and exchanged (Fedorov 1972; Mitchell 1974), by inner products alone.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from realitygap.diagnose.propose.explanations import Question
from realitygap.diagnose.propose.odds import Belief, deviation, expected
from realitygap.robot.drive import Array

ENOUGH = float(np.log(1000.0))
"""Odds beyond this settle a question: more counts by orders of magnitude."""
MORE = 0.05
"""How much the questions beside the worst count, and the values beside the one that is told least."""
PASSES = 3
"""Passes of exchanges at most."""
LITTLE = 1e-6
"""A gain no larger than this is none."""
APART = 1.0
"""Logarithm of odds: a question that all segments together move by less is not for these segments to settle."""


Goal = Callable[[Array], Array]
"""What motions are worth, by the gram of what they would show, any number of them: (..., c, c) -> (...)."""


@dataclass(frozen=True)
class Answer:
    """What motions do to a question.

    Attributes:
        one, other: the expected logarithm of the odds for each side, if it is the true one.
        alike: whether what is expected if a side is true is what the other one does too, refitted. Its odds are then
            those of being simpler, and no motion shows more.
    """

    one: float
    other: float
    alike: tuple[bool, bool] = (False, False)

    @property
    def least(self) -> float:
        """The smaller of both; of the side alone that could be shown, where the other one could not."""
        sides = zip((self.one, self.other), self.alike, strict=True)
        return min((odds for odds, alike in sides if not alike), default=min(self.one, self.other))

    def moves(self, question: Question) -> bool:
        """Whether the odds become others by what is seen, whichever side is true."""
        more = zip((self.one - question.now, self.other + question.now), self.alike, strict=True)
        return any(gain > APART and not alike for gain, alike in more)

    def shows(self, question: Question) -> str:
        """The side that alone could be shown, since it does all that the other one does; empty where both could."""
        one, other = question.names
        return {(True, False): other, (False, True): one}.get(self.alike, "")


def answer(question: Question, gram: Array, beliefs: Sequence[Belief]) -> Answer:
    """What motions would do to a question."""
    one, other = _sides(question, gram, beliefs)
    return Answer(float(one), float(other))


def _sides(question: Question, gram: Array, beliefs: Sequence[Belief]) -> tuple[Array, Array]:
    """The expected logarithm of the odds for each side, if it is the true one. Shape (..., c, c) -> (...) each."""
    a, b = beliefs[question.one], beliefs[question.other]
    return question.now + expected(gram, a, b), -question.now + expected(gram, b, a)


def told(least: Array) -> Array:
    """How well questions are settled, by the smaller logarithm of the odds of both sides: as it is up to `ENOUGH`,
    beyond by orders of magnitude. How far laws are off is a share of what a motion shows, and takes its share of all.
    """
    return np.asarray(np.arcsinh(least / ENOUGH))


def shares(settled: Array, still: Array, most: Array) -> Array:
    """What is had of what can be had of questions, all in one: the worst counts, the others a little. A standardised
    maximin criterion (Dette 1997): of explanations that hardly part, what little can be had counts no more than what
    much there is of others.

    Args:
        settled: how well motions settle each question. Shape (..., q) -> (...).
        still: how well the recordings do. Shape (q,).
        most: how well the best motion for each does. Shape (q,).
    """
    there = most - still
    had = np.where(there > LITTLE, (settled - still) / np.maximum(there, LITTLE), 1.0)
    return np.asarray(had.min(axis=-1) + MORE * had.mean(axis=-1))


@dataclass(frozen=True)
class Settling:
    """How much of what motions could do to each question alone they do.

    Attributes:
        questions: to be settled.
        beliefs: of every explanation.
        still: how well the recordings settle each. Shape (q,).
        most: how well the best motion for each alone does. Shape (q,).
    """

    questions: Sequence[Question]
    beliefs: Sequence[Belief]
    still: Array
    most: Array

    def __call__(self, gram: Array) -> Array:
        """Shape (..., c, c) -> (...)."""
        return shares(_settled(self.questions, self.beliefs, gram), self.still, self.most)


def _settled(questions: Sequence[Question], beliefs: Sequence[Belief], gram: Array) -> Array:
    """Shape (..., c, c) -> (..., q)."""
    return told(np.stack([np.minimum(*_sides(q, gram, beliefs)) for q in questions], axis=-1))


def settling(
    questions: Sequence[Question],
    beliefs: Sequence[Belief],
    groups: Sequence[tuple[Sequence[Array], Sequence[float]]],
    room: float,
) -> Settling:
    """The goal of settling questions by segments, of one group at a time: their grams, and the seconds that each takes,
    of which there is some room.
    """
    nothing, most = np.zeros((len(beliefs[0].mean),) * 2), []
    for q in questions:
        alone = partial(_one, q, beliefs)
        taken = [(grams, chosen(alone, grams, seconds, room)) for grams, seconds in groups]
        most.append(max(float(alone(nothing + sum(grams[i] for i in t))) for grams, t in taken))
    return Settling(questions, beliefs, _settled(questions, beliefs, nothing), np.array(most))


def _one(question: Question, beliefs: Sequence[Belief], gram: Array) -> Array:
    return np.asarray(_settled([question], beliefs, gram)[..., 0])


def separable(questions: Sequence[Question], grams: Sequence[Array], beliefs: Sequence[Belief]) -> list[Question]:
    """The questions that all segments together would move."""
    if not grams:
        return []
    whole = np.sum(grams, axis=0)
    return [q for q in questions if answer(q, whole, beliefs).least + abs(q.now) > APART]


def sharpened(belief: Belief, values: int, gram: Array) -> Array:
    """How many times smaller the standard deviations of an explanation's own values become. Shape (..., values)."""
    before = np.sqrt(np.diag(belief.covariance)[:values])
    return np.asarray(before / deviation(gram, belief)[..., :values])


def sharper(belief: Belief, values: int, gram: Array) -> Array:
    """How well motions tell an explanation's own values: the one that is told least counts, the others a little. Shape
    (..., c, c) -> (...).
    """
    gains = np.log(sharpened(belief, values, gram))
    return np.asarray(gains.min(axis=-1) + MORE * gains.mean(axis=-1))


def chosen(goal: Goal, grams: Sequence[Array], seconds: Sequence[float], room: float) -> list[int]:
    """The segments that serve a goal best within some time, by number.

    Args:
        goal: what motions are worth, by their gram.
        grams: of every segment. Shape (c, c) each.
        seconds: that every segment takes.
        room: seconds that there are.
    """
    taken = list[int]()
    if not grams:
        return taken
    every, length = np.array(grams), np.array(seconds)
    while True:
        fitting = _fitting(taken, length, room)
        if not fitting:
            break
        total = every[taken].sum(axis=0)
        gains = (goal(total + every[fitting]) - goal(total)) / length[fitting]
        if gains.max() <= LITTLE:
            break
        taken.append(fitting[int(np.argmax(gains))])
    return _exchanged(taken, goal, every, length, room)


def _fitting(taken: Sequence[int], length: Array, room: float) -> list[int]:
    """The segments that there is time for beside those that are taken."""
    left = room - float(length[list(taken)].sum())
    return [i for i in range(len(length)) if i not in taken and length[i] <= left]


def _exchanged(taken: list[int], goal: Goal, every: Array, length: Array, room: float) -> list[int]:
    """The same with segments exchanged for better ones that fit, as long as that helps."""
    best = float(goal(every[taken].sum(axis=0)))
    for _ in range(PASSES):
        before = best
        for place in range(len(taken)):
            others = taken[:place] + taken[place + 1 :]
            fitting = _fitting(others, length, room)
            tried = goal(every[others].sum(axis=0) + every[fitting])
            if tried.max() > best + LITTLE:
                taken, best = [*others, fitting[int(np.argmax(tried))]], float(tried.max())
        if best == before:
            break
    return taken
