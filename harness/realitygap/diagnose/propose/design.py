"""Design: which segments, one behind the other, part the explanations most, within a length.

What segments tell adds up, because each starts and ends at rest in the same pose. The best are therefore added one
after the other and exchanged (Fedorov 1972; Mitchell 1974), by inner products alone.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from realitygap.diagnose.propose.explanations import Question
from realitygap.diagnose.propose.odds import Belief, deviation, expected
from realitygap.robot.drive import Array

ENOUGH = float(np.log(1000.0))
"""Odds beyond this settle a question: more counts little."""
MORE = 0.05
"""How much more than that counts, and the questions beside the worst."""
PASSES = 3
"""Passes of exchanges at most."""
APART = 1.0
"""Logarithm of odds: a question that all segments together move by less is not for these segments to settle."""


Goal = Callable[[Array], float]
"""What motions are worth, by the gram of what they would show."""


@dataclass(frozen=True)
class Answer:
    """What motions do to a question: the expected logarithm of the odds for each side, if it is the true one."""

    one: float
    other: float

    @property
    def least(self) -> float:
        """The smaller of both."""
        return min(self.one, self.other)

    def moves(self, question: Question) -> bool:
        """Whether the odds become others, whichever side is true."""
        return max(self.one - question.now, self.other + question.now) > APART


def answer(question: Question, gram: Array, beliefs: Sequence[Belief]) -> Answer:
    """What motions would do to a question."""
    a, b = beliefs[question.one], beliefs[question.other]
    return Answer(question.now + expected(gram, a, b), -question.now + expected(gram, b, a))


def worth(questions: Sequence[Question], beliefs: Sequence[Belief], gram: Array) -> float:
    """How well motions settle questions: the worst counts, the others a little."""
    least = [answer(q, gram, beliefs).least for q in questions]
    told = [min(x, ENOUGH) + MORE * max(x - ENOUGH, 0.0) ** 0.5 for x in least]
    return float(min(told) + MORE * np.mean(told))


def separable(questions: Sequence[Question], grams: Sequence[Array], beliefs: Sequence[Belief]) -> list[Question]:
    """The questions that all segments together would move."""
    if not grams:
        return []
    whole = np.sum(grams, axis=0)
    return [q for q in questions if answer(q, whole, beliefs).least + abs(q.now) > APART]


def sharpened(belief: Belief, values: int, gram: Array) -> Array:
    """How many times smaller the standard deviations of an explanation's own values become. Shape (values,)."""
    before = np.sqrt(np.diag(belief.covariance)[:values])
    return np.asarray(before / deviation(gram, belief)[:values])


def sharper(belief: Belief, values: int, gram: Array) -> float:
    """How well motions tell an explanation's own values: the one that is told least counts, the others a little."""
    gains = np.log(sharpened(belief, values, gram))
    return float(gains.min() + MORE * gains.mean())


def chosen(goal: Goal, grams: Sequence[Array], seconds: Sequence[float], room: float) -> list[int]:
    """The segments that serve a goal best within some time, by number.

    Args:
        goal: what motions are worth, by their gram.
        grams: of every segment. Shape (c, c) each.
        seconds: that every segment takes.
        room: seconds that there are.
    """

    def value(numbers: Sequence[int]) -> float:
        return goal(np.sum([np.zeros_like(grams[0]), *(grams[i] for i in numbers)], axis=0))

    if not grams:
        return []
    taken: list[int] = []
    while True:
        left = room - sum(seconds[i] for i in taken)
        fitting = [i for i in range(len(grams)) if i not in taken and seconds[i] <= left]
        now = value(taken)
        gains = [((value([*taken, i]) - now) / seconds[i], i) for i in fitting]
        if not gains or max(gains)[0] <= 1e-6:
            break
        taken.append(max(gains)[1])
    return _exchanged(taken, value, seconds, room)


def _exchanged(
    taken: list[int], value: Callable[[Sequence[int]], float], seconds: Sequence[float], room: float
) -> list[int]:
    """The same with segments exchanged for better ones that fit, as long as that helps."""
    best = value(taken)
    for _ in range(PASSES):
        before = best
        for place in range(len(taken)):
            others = taken[:place] + taken[place + 1 :]
            left = room - sum(seconds[i] for i in others)
            tried = [(value([*others, i]), i) for i in range(len(seconds)) if i not in others and seconds[i] <= left]
            most, number = max(tried)
            if most > best + 1e-6:
                taken, best = [*others, number], most
        if best == before:
            break
    return taken
