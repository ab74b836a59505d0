"""Odds in words, and what a motion will settle in one sentence."""

from __future__ import annotations

import math

from realitygap.diagnose.propose.design import Answer
from realitygap.diagnose.propose.explanations import Question
from realitygap.diagnose.propose.proposal import Proposal, Proposed, Weak
from realitygap.diagnose.result.odds import MOST
from realitygap.diagnose.result.story_text import interval, suspect_label
from realitygap.page.style import power_of_ten

SURE = math.log(20.0)
"""Odds beyond this settle a question: those at which a diagnosis takes a rival out of the confidence set."""
WEAKEST = 3
"""Values that are told in one sentence: the weakest."""


def odds(logarithm: float) -> str:
    """Odds as people say them: 40 : 1, 1 : 3, more than 10⁶ : 1."""
    decades = abs(logarithm) / math.log(10.0)
    size = math.exp(min(abs(logarithm), 100.0))
    number = f"{size:.1f}" if size < 10.0 else f"{float(f'{size:.2g}'):.0f}"
    if decades >= MOST:
        number = f"more than {power_of_ten(MOST)}"
    elif decades >= 4:
        number = power_of_ten(int(decades))
    return f"{number} : 1" if logarithm >= 0.0 else f"1 : {number}"


OPEN = "stays open"


def expected(question: Question, answer: Answer) -> str:
    """The odds that are expected for whichever side is true: the smaller ones, where the motion turns them its way."""
    return odds(answer.least) if answer.moves(question) and answer.least > 0.0 else OPEN


def one_sided(question: Question, answer: Answer) -> str:
    """What a motion cannot show of a question, since one side does all that the other one does; empty where it can."""
    side = answer.shows(question)
    told = side and expected(question, answer) != OPEN
    return f"if it is {side}, which does all that the other one does" if told else ""


def now(question: Question) -> str:
    """The odds on the present recordings, for the side that is named first."""
    return odds(question.now)


def settles(result: Proposal, proposed: Proposed) -> str:
    """What a motion will settle: every question that it moves, with the expected odds."""
    reached = result.reached(proposed)
    if result.shown is not None:
        return ", ".join(s.label for s in proposed.motion.segments)
    if not reached:
        return "; ".join(narrower(w) for w in proposed.weak[:WEAKEST])
    return "; ".join(_settles(q, a) for q, a in reached)


def _settles(question: Question, answer: Answer) -> str:
    then = expected(question, answer)
    if then == OPEN:
        return f"{question} {then}"
    return f"{question}: expected odds {then} (now {now(question)}) {one_sided(question, answer)}".rstrip()


def narrower(weak: Weak) -> str:
    """What a motion does to an interval: controller gain at elbow: ± 0.20 becomes ± 0.10 duty/rad, half after 40 s."""
    what = suspect_label(weak.suspect) + (f", {weak.parameter}" if len(weak.suspect.kind.parameters) > 1 else "")
    return f"{what}: ± {interval(weak.now, weak.then, weak.unit, word='becomes ±', digits=2)}, {half(weak)}"


def half(weak: Weak) -> str:
    """How long one has to record until an interval is half as wide."""
    return f"half after {weak.half:.0f} s" if math.isfinite(weak.half) else "never half by this motion"
