"""The file of `realitygap bench servo`: what was measured, in which units, and what the data sheet says."""

from pathlib import Path
from typing import Literal

from pydantic import Field

from realitygap.bench.quantity import (
    AngleUnit,
    CurrentUnit,
    DutyUnit,
    Inertia,
    Load,
    LoadUnit,
    Speed,
    SpeedUnit,
    Torque,
    TorqueUnit,
    Voltage,
    VoltageUnit,
)
from realitygap.files.errors import InputError
from realitygap.files.validation import validate
from realitygap.files.yaml_file import load_yaml
from realitygap.scenario.section import Patterns, Section
from realitygap.scenario.which_file import check_kind


class ServoUnits(Section):
    """Units of the table columns of these names."""

    torque: TorqueUnit
    speed: SpeedUnit
    supply: VoltageUnit
    load: LoadUnit


class Signal(Section):
    """A signal of a bag; of an array the first element is taken."""

    topic: str = Field(description="topic")
    field: str = Field(description="field of the message, such as effort, velocity, angular_velocity.z")


class SpeedSignal(Signal):
    """An angular velocity."""

    unit: SpeedUnit


class TorqueSignal(Signal):
    """A torque."""

    unit: TorqueUnit


class LoadBag(Section):
    """A recording of one motor lifting one load."""

    path: str = Field(description="a bag")
    motor: str = Field(description="name of the motor")
    type: str = Field(description="motor type")
    condition: Literal["new", "used"] | None = Field(default=None, description="new or used")
    supply: Voltage = Field(description="supply voltage with its unit")
    load: Load = Field(description="load with its unit")


class Sweep(Section):
    """Torque and speed per load: of each bag, the largest speed and the torque at that moment."""

    bags: list[LoadBag] = Field(min_length=1, description="the bags")
    speed: SpeedSignal = Field(description="the speed's topic, field and unit")
    torque: TorqueSignal = Field(description="the torque's topic, field and unit")


class FrictionTable(Section):
    """Static friction per motor: columns type, motor, friction and perhaps supply."""

    table: str = Field(description="a CSV or Parquet table with the columns type, motor, friction")
    unit: TorqueUnit


class DataSheet(Section):
    """What the manufacturer claims."""

    supply: Voltage = Field(description="supply voltage of the claims, with its unit")
    stall_torque: Torque = Field(description="with its unit, such as 10.0 N·m")
    no_load_speed: Speed = Field(description="with its unit, such as 55 rev/min")


class MotorType(Section):
    """What is known of a motor type beforehand."""

    name: str = Field(description="the type's name in the tables")
    datasheet: DataSheet | None = Field(default=None, description="what the manufacturer claims")
    stated_friction: Torque | None = Field(default=None, description="a mean stated elsewhere, to check")
    joints: Patterns = Field(default=["*"], description="the joints that such motors drive, for the servo's text")
    gain: float | None = Field(default=None, description="the controller's gain [duty per rad], for the servo's text")


class PositionSignal(Signal):
    """An angle."""

    unit: AngleUnit


class CurrentSignal(Signal):
    """A motor current."""

    unit: CurrentUnit


class DutySignal(Signal):
    """A duty cycle."""

    unit: DutyUnit


class Arm(Section):
    """The moving part of a test bench, about the motor's axis: a URDF, or its two numbers."""

    name: str = Field(description="name of the arm")
    urdf: str | None = Field(default=None, description="URDF with one moving joint whose axis is horizontal")
    inertia: Inertia | None = Field(default=None, description="about the axis, with its unit (kg·m²)")
    gravity_torque: Torque | None = Field(default=None, description="m·g·l, with its unit (N·m)")


class ArmBag(Section):
    """A recording with one of the arms."""

    path: str = Field(description="a bag")
    arm: str = Field(description="name of the arm")


class ArmRecordings(Section):
    """Recordings of a motor that moves known arms. An angle of 0 hangs down."""

    position: PositionSignal = Field(description="the angle's topic, field and unit")
    current: CurrentSignal = Field(description="the motor current's topic, field and unit")
    duty: DutySignal | None = Field(default=None, description="the duty's topic, field and unit")
    arms: list[Arm] = Field(default=[], description="the arms")
    sines: list[ArmBag] = Field(default=[], description="slow sines under several loads: torque per ampere, friction")
    chirps: list[ArmBag] = Field(default=[], description="fast motions: rotor inertia")
    horizontal: list[str] = Field(default=[], description="bags with given duty and no gravity: no-load speed per duty")


class ServoBench(Section):
    """A servo bench."""

    units: ServoUnits | None = Field(default=None, description="units of the columns torque, speed, supply and load")
    torque_speed: str | Sweep | None = Field(
        default=None,
        description="a table with the columns type, motor, supply, load, torque, speed and perhaps condition; or bags",
    )
    regression: Literal["torque_on_speed", "speed_on_torque"] = Field(
        default="torque_on_speed", description="the second variable is taken as exact, the first carries the error"
    )
    nominal_supply: Voltage | None = Field(default=None, description="the supply for the URDF's numbers, with its unit")
    static_friction: FrictionTable | None = Field(default=None, description="static friction per motor")
    types: list[MotorType] = Field(default=[], description="what is known of the motor types")
    recordings: ArmRecordings | None = Field(default=None, description="recordings of a motor that moves known arms")


def load_servo_bench(path: Path) -> ServoBench:
    """The checked bench file.

    Raises:
        InputError: one sentence on the first thing that is wrong.
    """
    raw = load_yaml(path)
    check_kind(path, "a bench of servos", raw)
    bench = validate(path, ServoBench, raw)
    if bench.torque_speed is None and bench.static_friction is None and bench.recordings is None:
        raise InputError(f"{path}: names no measurement; expected torque_speed, static_friction or recordings")
    if isinstance(bench.torque_speed, str) and bench.units is None:
        raise InputError(f"{path}: units: is missing; expected the units of torque, speed, supply and load")
    for what, names in (
        ("types", [t.name for t in bench.types]),
        ("recordings.arms", [a.name for a in bench.recordings.arms] if bench.recordings else []),
    ):
        double = next((n for n in names if names.count(n) > 1), None)
        if double is not None:
            raise InputError(f"{path}: {what}: {double} stands twice; expected every name once")
    return bench
