"""Evidence as people read it: odds, how many times more probable one explanation makes the recordings than another."""

import math

from realitygap.page.style import number, power_of_ten

MOST = 6
"""Odds are told up to so many decades: beyond, a model's own faults decide."""


def odds(evidence: float) -> str:
    """The odds of which a gain in evidence is the natural logarithm, as people say them: 1.5, 40, more than 10⁶."""
    decades = evidence / math.log(10)
    if decades > MOST:
        return f"more than {power_of_ten(MOST)}"
    if decades >= 4:
        return power_of_ten(round(decades))
    times = math.exp(max(evidence, 0.0))
    return number(times, 2) if times < 9.95 else f"{times:.0f}"
