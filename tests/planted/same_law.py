"""Two effects that together say what a third one says: friction that differs by direction.

A bound from -forward to backward is Coulomb friction of their mean beside a constant effort of half their difference.
"""

from typing import Any

DIRECTION, DRY, CONSTANT = "direction_friction", "coulomb_friction", "constant_effort"
Finding = dict[str, Any]


def as_told(findings: list[Finding], truths: list[Finding]) -> list[Finding]:
    """The findings in the words of the truth, where they say the same law in the other ones."""
    planted = {(t["effect"], t["target"]) for t in truths}
    out = list(findings)
    for joint in {t["target"] for t in truths}:
        one, two = (DIRECTION, joint), {(DRY, joint), (CONSTANT, joint)}
        named = {(f["effect"], _single(f)): f for f in out}
        if one in planted and two <= set(named) and one not in named:
            dry, constant = named[DRY, joint], named[CONSTANT, joint]
            c, e = _value(dry, "torque"), _value(constant, "effort")
            joined = {"effect": DIRECTION, "target": joint, "parameters": _values(forward=c - e, backward=c + e)}
            out = [joined if f is dry else f for f in out if f is not constant]
        elif two <= planted and one in named and not two & set(named):
            both = named[one]
            f, b = _value(both, "forward"), _value(both, "backward")
            apart = [
                {"effect": DRY, "target": joint, "parameters": _values(torque=0.5 * (f + b))},
                {"effect": CONSTANT, "target": joint, "parameters": _values(effort=0.5 * (b - f))},
            ]
            out = [x for f in out for x in (apart if f is both else [f])]
    return out


def _single(finding: Finding) -> str:
    target = finding["target"]
    return target if isinstance(target, str) else (target[0] if len(target) == 1 else "")


def _value(finding: Finding, name: str) -> float:
    return float(finding["parameters"][name]["value"])


def _values(**values: float) -> dict[str, dict[str, float]]:
    """Parameters without an interval."""
    return {k: {"value": v} for k, v in values.items()}
