"""Quantities with units, in a bench file (`7.3 N·m`) and as the unit of a table column."""

import math
import re
from dataclasses import dataclass, field
from typing import Annotated, Any

from pydantic import BeforeValidator, Field
from pydantic.fields import FieldInfo


@dataclass(frozen=True)
class Written:
    """How a value stands in a file, where that is not what it becomes: in the words of its reference, and for editors
    (`form`, JSON Schema).
    """

    words: str
    form: dict[str, Any] = field(hash=False)

    def __get_pydantic_json_schema__(self, core: Any, handler: Any) -> dict[str, Any]:
        """What pydantic puts into the JSON Schema in place of the type that the value becomes."""
        del core, handler
        return dict(self.form)


UNITS: dict[str, dict[str, float]] = {
    "torque": {"N·m": 1.0, "N·cm": 1e-2, "mN·m": 1e-3, "kgf·cm": 9.80665e-2},
    "speed": {"rad/s": 1.0, "deg/s": math.pi / 180, "rev/min": 2 * math.pi / 60, "rpm": 2 * math.pi / 60},
    "angle": {"rad": 1.0, "deg": math.pi / 180},
    "voltage": {"V": 1.0, "mV": 1e-3},
    "current": {"A": 1.0, "mA": 1e-3},
    "duty": {"1": 1.0, "%": 1e-2},
    "load": {"kg": 1.0, "g": 1e-3, "N": 1.0, "N·m": 1.0},
    "mass": {"kg": 1.0, "g": 1e-3},
    "length": {"m": 1.0, "cm": 1e-2, "mm": 1e-3},
    "inertia": {"kg·m²": 1.0, "g·cm²": 1e-7, "kg·mm²": 1e-6},
}
"""Units by dimension, as factors to SI. `load` only labels what hung on the motor, so that its units may differ."""

_SPELLING = {"Nm": "N·m", "N.m": "N·m", "N*m": "N·m", "Ncm": "N·cm", "mNm": "mN·m", "kg*m^2": "kg·m²", "kg m²": "kg·m²"}


def factor(dimension: str, unit: str) -> float:
    """The SI value of one unit. Raises ValueError, naming the known units, for one that is not of the dimension."""
    known = UNITS[dimension]
    unit = _SPELLING.get(unit.strip(), unit.strip())
    if unit not in known:
        raise ValueError(f"expected a unit of {dimension}: one of {', '.join(known)}")
    return known[unit]


def _quantity(dimension: str) -> BeforeValidator:
    def parse(value: Any) -> float:
        known = ", ".join(UNITS[dimension])
        if isinstance(value, int | float) and not isinstance(value, bool):
            raise ValueError(f"its unit is missing; expected a {dimension} with its unit, one of {known}")
        number, _, unit = str(value).strip().partition(" ")
        try:
            result = float(number) * factor(dimension, unit)
        except ValueError:
            raise ValueError(f"expected a number and a unit of {dimension}, one of {known}") from None
        if not math.isfinite(result):
            raise ValueError("expected a finite number")
        return result

    return BeforeValidator(parse)


def _unit(dimension: str) -> BeforeValidator:
    def check(value: Any) -> float:
        return factor(dimension, str(value))

    return BeforeValidator(check)


def _spelled(dimension: str) -> list[str]:
    """The units of a dimension in every spelling that is known."""
    return [*UNITS[dimension], *(other for other, unit in _SPELLING.items() if unit in UNITS[dimension])]


def _written(dimension: str) -> Written:
    units = "|".join(re.sub(r"[.*+^]", r"\\\g<0>", unit) for unit in _spelled(dimension))
    number = r"[-+]?[0-9_.]+([eE][-+]?[0-9]+)?"
    example = f"1.5 {next(iter(UNITS[dimension]))}"
    form = {"type": "string", "pattern": rf"^\s*{number}\s+({units})\s*$", "examples": [example]}
    return Written(f"number and unit of {dimension}", form)


def _written_unit(dimension: str) -> Written:
    numbers = [int(unit) for unit in UNITS[dimension] if unit.isdigit()]  # of a duty: 1
    return Written("text", {"enum": [*_spelled(dimension), *numbers]})


Torque = Annotated[float, _quantity("torque"), _written("torque")]
Speed = Annotated[float, _quantity("speed"), _written("speed")]
Voltage = Annotated[float, _quantity("voltage"), Field(gt=0), _written("voltage")]
Inertia = Annotated[float, _quantity("inertia"), Field(ge=0), _written("inertia")]
Load = Annotated[float, _quantity("load"), _written("load")]


def _described(dimension: str) -> FieldInfo:
    described: FieldInfo = Field(description=f"unit of {dimension}, one of {', '.join(UNITS[dimension])}")
    return described


TorqueUnit = Annotated[float, _unit("torque"), _written_unit("torque"), _described("torque")]
SpeedUnit = Annotated[float, _unit("speed"), _written_unit("speed"), _described("speed")]
AngleUnit = Annotated[float, _unit("angle"), _written_unit("angle"), _described("angle")]
VoltageUnit = Annotated[float, _unit("voltage"), _written_unit("voltage"), _described("voltage")]
CurrentUnit = Annotated[float, _unit("current"), _written_unit("current"), _described("current")]
DutyUnit = Annotated[float, _unit("duty"), _written_unit("duty"), _described("duty")]
LoadUnit = Annotated[float, _unit("load"), _written_unit("load"), _described("load")]
MassUnit = Annotated[float, _unit("mass"), _written_unit("mass"), _described("mass")]
LengthUnit = Annotated[float, _unit("length"), _written_unit("length"), _described("length")]
