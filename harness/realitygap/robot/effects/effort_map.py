"""An effort that is measured and that no law explains."""

import math
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from itertools import pairwise
from typing import Any

from realitygap.files.errors import InputError, did_you_mean
from realitygap.files.found import shown
from realitygap.robot.effects.effect import Effect, Page
from realitygap.robot.effects.joint import anywhere
from realitygap.robot.effects.motor import CONSTANT_EFFORT
from realitygap.robot.effort_map import VARIABLES, EffortMap, Table
from realitygap.robot.plant import Plant

KEYS = ("variables", "knots", "values")


def read_map(given: Mapping[str, Any]) -> dict[str, Any]:
    """The checked variables, knots and values of a scenario, as tuples; of two variables, values is a row per knot.

    Raises:
        InputError: for a key, variable or number that cannot be used.
    """
    wrong = [k for k in given if k not in KEYS] or [k for k in KEYS if k not in given]
    if wrong:
        what = "unknown parameter" if wrong[0] in given else "is missing"
        raise InputError(f"{wrong[0]}: {what}; effort_map needs {', '.join(KEYS)}")
    names = given["variables"]
    if not isinstance(names, list | tuple) or len(names) not in (1, 2) or len(set(map(str, names))) < len(names):
        raise InputError(f"variables: found {shown(names)}; expected a list of one or two of {_known()}")
    for name in names:
        if name == "temperature":
            raise InputError(f"variables: found temperature, which no simulation knows; expected {_known()}")
        if name not in VARIABLES:
            hint = did_you_mean(str(name), VARIABLES)
            raise InputError(f"variables: found {shown(name)}; expected one of {_known()}{hint}")
    knots = given["knots"]
    if not isinstance(knots, list | tuple) or len(knots) != len(names):
        raise InputError(f"knots: found {shown(knots)}; expected a list of numbers for each of {len(names)}")
    grid = tuple(_numbers(row, f"knots[{k}]") for k, row in enumerate(knots))
    for name, row in zip(names, grid, strict=True):
        if any(b <= a for a, b in pairwise(row)):
            raise InputError(f"knots: those of {name} do not increase; expected increasing numbers")
    values = given["values"]
    if len(names) == 1:
        rows: tuple[tuple[float, ...], ...] = (_numbers(values, "values"),)
        expected = [1, len(grid[0])]
    else:
        if not isinstance(values, list | tuple):
            raise InputError(f"values: found {shown(values)}; expected a list of rows")
        rows = tuple(_numbers(row, f"values[{k}]") for k, row in enumerate(values))
        expected = [len(grid[0]), len(grid[1])]
    if len(rows) != expected[0] or any(len(row) != expected[1] for row in rows):
        shape = " x ".join(str(len(k)) for k in grid)
        raise InputError(f"values: do not fit the knots; expected {shape} numbers")
    return {"variables": tuple(names), "knots": grid, "values": rows if len(names) > 1 else rows[0]}


def _numbers(given: Any, what: str) -> tuple[float, ...]:
    numbers = isinstance(given, list | tuple) and len(given) > 0
    for x in given if numbers else ():
        numbers = numbers and isinstance(x, int | float) and not isinstance(x, bool) and math.isfinite(x)
    if not numbers:
        raise InputError(f"{what}: found {shown(given)}; expected a list of numbers")
    return tuple(float(x) for x in given)


def _known() -> str:
    return ", ".join(f"{name} [{unit}]" for name, unit in VARIABLES.items())


def _apply(plant: Plant, indices: list[int], values: Mapping[str, Any]) -> None:
    two = len(values["variables"]) > 1
    numbers = tuple(x for row in values["values"] for x in row) if two else tuple(values["values"])
    knots = tuple(tuple(k) for k in values["knots"])
    plant.maps += [EffortMap(j, tuple(values["variables"]), knots, numbers) for j in indices]


EFFORT_MAP = Effect(
    name="effort_map",
    changes="torque",
    sits_at="joint",
    parameters=(),
    signals=("position", "effort"),
    own=lambda _plant, _index: {},
    apply=_apply,
    possible=anywhere,
    read=read_map,
    example={"variables": ("angle",), "knots": ((-0.5, 0.0, 0.5),), "values": (0.1, -0.1, 0.1)},
    page=Page(
        physics="An effort that the recordings show and that no law on the list explains, as a table over what it "
        "depends on: one or two of angle, speed, error, load, reversal (the time since the last one) and supply. "
        "Several on one joint add up. It acts on the link, is linear between its knots and stays as it is at the "
        "outermost ones beyond them: it says nothing about where nothing was measured. It has no name and tells no "
        "cause; its place and its shape are "
        "what a mechanic may recognise.",
        equation="τ += the value between the knots of the variables",
        signature="Whatever it was drawn from.",
        confused_with="every law whose effort depends on the same variables: coulomb_friction (speed), cable_spring "
        "and torque_ripple (angle), load_dependent_friction (load and speed), gain_law (error). A law that explains "
        "as much is the better explanation, because it holds where nothing was measured.",
        source="Eilers, Marx: Flexible smoothing with B-splines and penalties, Statistical Science 11(2), 1996 (the "
        "smooth functions that such tables are drawn from).",
    ),
    repeatable=True,
)


@cache
def tabulated(table: Table) -> Effect:
    """The same effect with given variables and knots: its parameters are the values at the knots."""
    (effort,) = CONSTANT_EFFORT.parameters

    def add(plant: Plant, indices: list[int], values: Mapping[str, float]) -> None:
        numbers = tuple(float(values[name]) for name in table.names)
        plant.maps += [EffortMap(j, table.variables, table.knots, numbers) for j in indices]

    return replace(
        EFFORT_MAP,
        parameters=tuple(replace(effort, name=name) for name in table.names),
        apply=add,
        read=None,
        example={},
        scaled=lambda plant, index: dict.fromkeys(table.names, CONSTANT_EFFORT.first_size(plant, index)[effort.name]),
    )
