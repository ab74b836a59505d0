"""Odds in words, and what a motion will settle in one sentence."""

from __future__ import annotations

import math

from realitygap.diagnose.propose.design import Answer
from realitygap.diagnose.propose.explanations import Question
from realitygap.diagnose.propose.proposal import Proposal, Proposed

SURE = math.log(20.0)
"""Odds beyond this settle a question: those at which a diagnosis takes a rival out of the confidence set."""
MOST = 6
"""Odds are told up to so many decades: beyond, a model's own faults decide."""


def odds(logarithm: float) -> str:
    """Odds as people say them: 40 : 1, 1 : 3, more than 10^6 : 1."""
    decades = abs(logarithm) / math.log(10.0)
    size = math.exp(min(abs(logarithm), 100.0))
    number = f"{size:.1f}" if size < 10.0 else f"{float(f'{size:.2g}'):.0f}"
    if decades >= MOST:
        number = f"more than 10^{MOST}"
    elif decades >= 4:
        number = f"10^{int(decades)}"
    return f"{number} : 1" if logarithm >= 0.0 else f"1 : {number}"


def expected(answer: Answer) -> str:
    """The odds that are expected for whichever side is true: the smaller ones."""
    return odds(answer.least)


def now(question: Question) -> str:
    """The odds on the present recordings, for the side that is ahead."""
    return odds(abs(question.now))


def settles(result: Proposal, proposed: Proposed) -> str:
    """What a motion will settle: every question that it moves, with the expected odds."""
    reached = result.reached(proposed)
    return "; ".join(f"{q}: expected odds {expected(a)} (now {now(q)})" for q, a in reached)
