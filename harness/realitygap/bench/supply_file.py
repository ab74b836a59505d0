"""The file of `realitygap bench supply`: voltages at the motors, and how the motors hang on the supply."""

from pathlib import Path

from pydantic import Field

from realitygap.bench.quantity import CurrentUnit, VoltageUnit
from realitygap.files.errors import InputError
from realitygap.files.validation import validate
from realitygap.files.yaml_file import load_yaml
from realitygap.scenario.section import Positive, Section
from realitygap.scenario.which_file import check_kind


class SupplyUnits(Section):
    """Units of the table's columns."""

    voltage: VoltageUnit
    current: CurrentUnit | None = Field(default=None, description="unit of current, where there are currents: A or mA")


class Chain(Section):
    """Motors that hang on the supply one behind the other."""

    name: str = Field(description="name of the chain")
    motors: list[str] = Field(min_length=1, description="the motors, from the supply outwards")


class Drive(Section):
    """A DC motor, for what a drop does to it."""

    torque_constant: Positive = Field(description="N·m/A at the output shaft")
    resistance: Positive = Field(description="of the winding [Ω]")


class SupplyBench(Section):
    """A supply bench: one row per motor and load condition."""

    table: str = Field(
        description="a table with the columns motor, condition, measured and perhaps reported, current, supply"
    )
    units: SupplyUnits = Field(description="units of voltage and, where there are currents, current")
    chains: list[Chain] = Field(default=[], description="the chains of motors")
    drive: Drive | None = Field(default=None, description="a motor, for what the drop does to torque and speed")


def load_supply_bench(path: Path) -> SupplyBench:
    """The checked bench file.

    Raises:
        InputError: one sentence on the first thing that is wrong.
    """
    raw = load_yaml(path)
    check_kind(path, "a bench of a supply", raw)
    bench = validate(path, SupplyBench, raw)
    motors = [m for c in bench.chains for m in c.motors]
    double = next((m for m in motors if motors.count(m) > 1), None)
    if double is not None:
        raise InputError(f"{path}: chains: two motors under one name: {double} stands twice; expected every motor once")
    return bench
