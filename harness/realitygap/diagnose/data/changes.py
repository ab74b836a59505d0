"""Suspects and changes: an effect at a target, and the values it has there."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from realitygap.robot.drive import Array
from realitygap.robot.effects import EFFECTS, Effect
from realitygap.robot.effects.effort_map import tabulated
from realitygap.robot.effort_map import Table
from realitygap.robot.plant import Plant


@dataclass(frozen=True)
class Suspect:
    """An effect at a target: `target` as a scenario says it, `indices` of the joints or links it means, the name of
    the `servo`, where they are all joints of one, and the `table` of an effort that no law explains.
    """

    effect: str
    target: str | tuple[str, ...]
    indices: tuple[int, ...]
    servo: str = field(default="", compare=False)
    table: Table | None = None

    @property
    def where(self) -> str:
        """The target for people."""
        if isinstance(self.target, str):
            return self.target
        return f"the {len(self.target)} joints of servo {self.servo}" if self.servo else ", ".join(self.target)

    @property
    def kind(self) -> Effect:
        """The effect itself."""
        return EFFECTS[self.effect] if self.table is None else tabulated(self.table)

    @property
    def joints(self) -> tuple[int, ...]:
        """The joints that it belongs to: of a link, the one that moves it; -1 for the base."""
        return tuple(i - 1 for i in self.indices) if self.kind.sits_at == "link" else self.indices

    def possible(self, plant: Plant) -> bool:
        """Whether the effect can act there on a plant."""
        return all(self.kind.possible(plant, i) is None for i in self.indices)

    def __str__(self) -> str:
        over = f" over {' and '.join(self.table.variables)}" if self.table is not None else ""
        return f"{self.effect} at {self.where}{over}"


@dataclass(frozen=True)
class Change:
    """A suspect with the values of all its parameters; `free` names those that are fitted."""

    suspect: Suspect
    values: tuple[tuple[str, float], ...]
    free: tuple[str, ...] = ()

    @property
    def parameters(self) -> dict[str, float]:
        """Values by parameter name."""
        return dict(self.values)

    @property
    def spec(self) -> dict[str, Any]:
        """Its parameters as a scenario says them."""
        table = self.suspect.table
        return dict(self.values) if table is None else table.parameters([v for _, v in self.values])

    def at(self, values: Mapping[str, float]) -> Change:
        """The same with some of its parameters at other values."""
        return replace(self, values=tuple((self.parameters | dict(values)).items()))

    def absurd(self, plant: Plant) -> bool:
        """Whether its values are not the effect that it is of, on a plant."""
        why = self.suspect.kind.absurd
        return why is not None and any(why(plant, i, self.parameters) is not None for i in self.suspect.indices)


ModelKey = frozenset[tuple[Suspect, tuple[str, ...]]]
"""The identity of a model whatever its values: which findings it has, and what of each is free."""


def model_key(changes: Sequence[Change]) -> ModelKey:
    """The key of the model with some changes."""
    return frozenset((c.suspect, c.free) for c in changes)


def clash(a: Suspect, b: Suspect) -> bool:
    """Whether two suspects cannot stand together: the same effect, or one that excludes it, at a common target.

    Unnamed efforts add up where they depend on other things.
    """
    if a.kind.sits_at != b.kind.sits_at or not set(a.indices) & set(b.indices):
        return False
    if a.effect == b.effect:
        return a.table is None or b.table is None or a.table.variables == b.table.variables
    return a.kind.rules_out(b.kind)


def stands_beside(suspect: Suspect, others: Iterable[Suspect]) -> bool:
    """Whether a suspect can stand together with all others."""
    return not any(clash(suspect, other) for other in others)


def as_read(changes: Sequence[Change], before: Sequence[Change], plant: Plant) -> list[Change]:
    """Changes of which those that stood so `before` do the same at a joint's readings as before, if its zero is another
    now: what depends on its angle was found by its readings.
    """
    angular = [c for c in changes if c.suspect.kind.turned is not None and c in before]
    if not angular:
        return list(changes)
    zero, old = (changed(plant, c, plant).drive["offset"] for c in (changes, before))
    return [_turned(c, (zero - old)[list(c.suspect.indices)]) if c in angular else c for c in changes]


def _turned(change: Change, moved: Array) -> Change:
    """A change that does the same at the readings of its k joints, whose zeros moved: as it is where they moved apart.

    Args:
        change: of what depends on an angle.
        moved: how far each zero moved [rad or m]. Shape (k,).
    """
    turned, by = change.suspect.kind.turned, float(moved[0])
    if turned is None or by == 0.0 or (moved != by).any():
        return change
    return change.at(turned(change.parameters, by))


def changed(plant: Plant, changes: Sequence[Change], reference: Plant) -> Plant:
    """A plant with effects changed.

    Where a run's own value differs from that of the reference (another gain, another load), a change keeps its ratio
    to the reference: a gain that is 10 % low is 10 % low in every run. What may have either sign, as where a mass sits,
    keeps its difference: a centre 5 mm further out is that in every run.
    """
    out = plant.copy()
    for change in changes:
        alike: dict[tuple[tuple[str, float], ...], list[int]] = {}
        for i in change.suspect.indices:
            alike.setdefault(_there(change, plant, reference, i), []).append(i)
        for values, indices in alike.items():
            change.suspect.kind.apply(out, indices, dict(values))
    return out


def _there(change: Change, plant: Plant, reference: Plant, index: int) -> tuple[tuple[str, float], ...]:
    """The values of a change at a joint or link of a plant that may differ from the reference."""
    effect = change.suspect.kind
    here, there = effect.own(plant, index), effect.own(reference, index)
    values = []
    for name, value in change.values:
        own, first, p = here.get(name), there.get(name), effect.parameter(name)
        if p.absent is None and own is not None and first is not None and own != first:
            if p.low < 0.0:
                value = own + (value - first)
            elif first:
                value = value * own / first
        values.append((name, value))
    return tuple(values)
