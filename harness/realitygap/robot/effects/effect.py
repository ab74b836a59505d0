"""What an effect is: a piece of physics that a model may lack, as an edit of the plant."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from realitygap.robot.plant import Plant

Values = Mapping[str, float]


@dataclass(frozen=True)
class Parameter:
    """A number that an effect has.

    Attributes:
        name, unit: as in the scenario file and in tables.
        low, high: bounds of what is physical and worth fitting.
        first: a sensible first size where nothing is known of the joint (see `Effect.first_size`).
        absent: the neutral value of an effect that is absent from every model (marked with a raised 0 in tables);
            None where the neutral value is the model's own.
        default: the value where the scenario leaves it out; None where it must be given.
        logarithmic: whether sizes are compared by ratio.
        shape: a parameter that does nothing on its own (an exponent, a phase) and is not fitted first.
        typical: of a shape that may as well be about zero, as a phase or a place: a size of it that is neither
            negligible nor absurd, where its value says nothing of that; 0 of all else.
    """

    name: str
    unit: str
    low: float
    high: float
    first: float
    absent: float | None = None
    default: float | None = None
    logarithmic: bool = False
    shape: bool = False
    typical: float = 0.0

    @property
    def with_unit(self) -> str:
        """Its name, and its unit in brackets where it has one."""
        return f"{self.name} [{self.unit}]" if self.unit else self.name


@dataclass(frozen=True)
class Page:
    """What a person reads about an effect."""

    physics: str
    equation: str
    signature: str
    confused_with: str
    source: str


@dataclass(frozen=True)
class Effect:
    """One effect. `apply` edits a plant; `own` tells the values that the plant has already, which change nothing.

    Attributes:
        name: fixed, as in scenario and diagnosis files.
        changes: the one thing that it edits.
        sits_at: what a target names.
        parameters: in the order of tables.
        signals: what it touches first.
        law: which of a model's laws it is a fault of, where that law is only nearly right; empty for what is no fault
            of friction, drive, load or contact.
        own: (plant, index) -> values; the index is of a joint or link, 0 for ground and base.
        apply: (plant, indices, values) -> None, edits the plant in place; values are totals, and a parameter with a
            default that is left out stays.
        possible: (plant, index) -> a reason in words why it cannot act there, or None.
        page: physics, equation, signature, confusions, source.
        scaled: (plant, index) -> first sizes that suit this joint, link or ground, where they depend on it.
        largest: (plant, index) -> the largest values that can be there, where that is less than a parameter's bound.
        excludes: effects that say the same thing another way and cannot stand on the same target.
        special_of: effects with more values of which it is a special case, or one so nearly that their names mean the
            same fault: dry friction, of one that differs by direction; a heavier link, of a load that is fixed to it.
        dissipative: it can only take energy out.
        everywhere: every machine has a little of it, so that it is no name until it is clearly more than usual.
        unseen_when_followed: why it says nothing about the effort of a motion that is followed; empty where it does.
        absurd: (plant, index, values) -> a reason in words why these values are not this effect there, or None.
        contradiction: (values) -> what in them cannot be, and what was expected, or None.
        read: (keys of a scenario) -> checked values, of an effect whose parameters are tables instead of numbers.
        example: such values.
        repeatable: several of them may stand on one target, and add up.
        turned: (values, angle) -> the values that do the same at the joint's readings where its zero is that much
            further [rad or m], of what depends on a joint's angle; None for all else.
    """

    name: str
    changes: Literal["model", "torque", "command", "observation"]
    sits_at: Literal["joint", "link", "ground", "base"]
    parameters: tuple[Parameter, ...]
    signals: tuple[str, ...]
    own: Callable[[Plant, int], dict[str, float]]
    apply: Callable[[Plant, list[int], Values], None]
    possible: Callable[[Plant, int], str | None]
    page: Page
    scaled: Callable[[Plant, int], dict[str, float]] | None = None
    largest: Callable[[Plant, int], dict[str, float]] | None = None
    excludes: tuple[str, ...] = ()
    special_of: tuple[str, ...] = ()
    dissipative: bool = False
    everywhere: bool = False
    absurd: Callable[[Plant, int, Values], str | None] | None = None
    unseen_when_followed: str = ""
    contradiction: Callable[[Values], str | None] | None = None
    read: Callable[[Mapping[str, Any]], dict[str, Any]] | None = None
    example: Mapping[str, Any] = field(default_factory=dict)
    repeatable: bool = False
    law: Literal["friction", "drive", "load", "contact", ""] = ""
    turned: Callable[[Values, float], dict[str, float]] | None = None

    def parameter(self, name: str) -> Parameter:
        """The parameter of that name. Raises KeyError."""
        for parameter in self.parameters:
            if parameter.name == name:
                return parameter
        raise KeyError(name)

    def rules_out(self, other: "Effect") -> bool:
        """Whether the two say the same thing another way, so that only one of them can stand on a target."""
        return self.name in other.excludes or other.name in self.excludes

    def first_size(self, plant: Plant, index: int) -> dict[str, float]:
        """Values that are neither negligible nor absurd there, within bounds: for a first try and for planting."""
        if self.read:
            return dict(self.example)
        sizes = {p.name: p.first for p in self.parameters}
        sizes.update(self.scaled(plant, index) if self.scaled else {})
        return {p.name: min(max(sizes[p.name], p.low), p.high) for p in self.parameters}


def reads(**fields: str) -> Callable[[Plant, int], dict[str, float]]:
    """`own` of an effect whose parameters are fields of the drive."""
    return lambda plant, index: {name: float(plant.drive[field][index]) for name, field in fields.items()}


def writes(**fields: str) -> Callable[[Plant, list[int], Values], None]:
    """`apply` of an effect whose parameters are fields of the drive; what is left out stays."""

    def apply(plant: Plant, indices: list[int], values: Values) -> None:
        for name, column in fields.items():
            if name in values:
                plant.drive[column][indices] = values[name]

    return apply
