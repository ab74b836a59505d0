"""What findings stand in the place of: effects of the scenario that say the same thing another way."""

from __future__ import annotations

from collections.abc import Sequence

from realitygap.diagnose.data.changes import Change
from realitygap.diagnose.data.problem import Problem
from realitygap.robot.effects.place import known, targets


def replaced(problem: Problem, changes: Sequence[Change]) -> list[str]:
    """A sentence on every effect of the scenario in whose place a change is, as only one of them can stand there."""
    out = []
    for spec in problem.file.scenario.effects:
        effect = known(spec.effect)
        there = set(targets(problem.plant, effect, spec.target))
        has = ", ".join(f"{name} {value}" for name, value in spec.parameters.items())
        out += [
            f"{change.suspect} is in the place of the scenario's {effect.name} there ({has}), which it rules out"
            for change in changes
            if effect.rules_out(change.suspect.kind) and there.intersection(change.suspect.indices)
        ]
    return out
