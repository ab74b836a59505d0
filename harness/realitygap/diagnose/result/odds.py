"""Evidence as people read it: odds, how many times more probable one explanation makes the recordings than another."""

import math

from realitygap.page.style import number

MOST = 6
"""Odds are told up to so many decades: beyond, a model's own faults decide."""


def odds(evidence: float) -> str:
    """The odds of which a gain in evidence is the natural logarithm, as people say them: 1.5, 40, more than 10^6."""
    decades = evidence / math.log(10)
    if decades > MOST:
        return f"more than 10^{MOST}"
    if decades >= 4:
        return f"10^{decades:.0f}"
    times = math.exp(max(evidence, 0.0))
    return number(times, 2) if times < 9.95 else f"{times:.0f}"
