"""What a missing effort depends on, in a sentence that names variables and never a law."""

from collections.abc import Mapping
from typing import Any

from realitygap.missing.shape import BLOCK, Shape

DEPENDS = {
    "angle": "the angle",
    "speed": "the speed",
    "error": "the position error",
    "load": "the load",
    "reversal": "the time since the last reversal",
    "supply": "the supply",
    "temperature": "the temperature",
}
"""How a variable is called in a sentence."""
WITHIN = 0.9
"""How often its band must hold 0 for a missing effort to be what that leaves open."""


def sentence(shape: Shape) -> str:
    """What the missing effort of a joint depends on, with the share of its variance that each part explains."""
    size = f"the missing effort at {shape.joint} ({shape.size:.2g} {shape.unit} rms)"
    if not shape.terms:
        if shape.within > WITHIN:
            return f"{size} is no more than its band leaves open"
        if not shape.judged:
            return f"{size} is of too short a motion to tell what it depends on: record more than {BLOCK:g} s of motion"
        if abs(shape.mean) > shape.size / 2:
            return f"{size} is {shape.mean:.2g} {shape.unit} in the mean, and depends on nothing that was looked at"
        return f"{size} depends on nothing that was looked at"
    parts = [f"{depends(vars(term))} ({100 * term.share:.0f} % of its variance)" for term in shape.terms]
    text = f"{size} depends on {', and on '.join(parts)}"
    if shape.rivals:
        text += f"; as well by {' or '.join(_named(r) for r in shape.rivals)}"
    return text


def depends(term: Mapping[str, Any]) -> str:
    """What a part of a missing effort is a function of, in words: `the angle, 6 periods a turn`.

    Args:
        term: its `variables` and `periods`, as in `missing_effort.json`.
    """
    text = " and ".join(DEPENDS[v] for v in term["variables"])
    if len(term["variables"]) > 1:
        text += " together"
    return text if term["periods"] is None else f"{text}, {term['periods']:.2g} periods a turn"


def _named(variables: tuple[str, ...]) -> str:
    return " and ".join(DEPENDS[v] for v in variables)
