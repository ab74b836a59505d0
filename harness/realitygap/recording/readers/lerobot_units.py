"""From the units of a LeRobot data set to angles."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

import numpy as np

from realitygap.files.errors import InputError
from realitygap.files.plain_file import read_written
from realitygap.scenario.file import resolve_path
from realitygap.scenario.schema import DataSet

COUNTS = 4096
"""Encoder counts per turn of the servos that LeRobot calibrates (Feetech STS3215, Dynamixel X)."""
KEY = "recordings.dataset"


@dataclass(frozen=True)
class Scale:
    """angle = slope·value + offset [rad or m]; velocities have the slope alone."""

    slope: float
    offset: float


def scale_of(spec: DataSet, file: Path, joint: str, name: str) -> Scale:
    """What one joint's values mean.

    LeRobot maps the range of motion that was found in calibration, in encoder counts, to -100..100, or 0..100 for a
    gripper; in degrees, 0 is the middle of that range (`MotorsBus._normalize` of huggingface/lerobot).

    Args:
        spec: what the scenario says of its data sets.
        file: the scenario, for messages and relative paths.
        joint: the robot's name of the joint, for patterns.
        name: the data set's, for the calibration file.

    Raises:
        InputError: where normalized units come without calibration or range, or with both.
    """
    units = spec.units if isinstance(spec.units, str) else _chosen(spec.units, joint)
    if units is None:
        raise InputError(f"{file}: {KEY}.units: no pattern matches joint {joint}; expected a unit for every joint")
    if units == "radians":
        return Scale(1.0, 0.0)
    if units == "degrees":
        return Scale(np.pi / 180, 0.0)
    from_zero = units == "percent" or "gripper" in name.lower()
    least, width = (0.0, 100.0) if from_zero else (-100.0, 200.0)
    stated = _chosen(spec.range, joint)
    if stated is None and spec.calibration is not None:
        half = _calibrated(file, spec.calibration, name) / 2
        stated = -half, half
    if stated is None:
        raise InputError(
            f"{file}: {KEY}: joint {joint} is in {units} units; expected calibration: FILE (LeRobot's JSON of the arm) "
            f"or range: {{{joint}: [LOW, HIGH]}} in rad, which say what they are in angles"
        )
    low, high = stated
    slope = (high - low) / width
    return Scale(slope, low - slope * least)


def _chosen(patterns: Mapping[str, Any], joint: str) -> Any:
    return next((value for pattern, value in patterns.items() if fnmatchcase(joint, pattern)), None)


def _calibrated(file: Path, text: str, name: str) -> float:
    """The width of a motor's range of motion [rad] in a calibration file."""
    path = resolve_path(file, text, f"{KEY}.calibration")
    try:
        found = json.loads(read_written(path))
    except (OSError, ValueError) as error:
        raise InputError(
            f"{path}: cannot be read ({' '.join(str(error).split())}); expected LeRobot's calibration (JSON), named "
            f"by {KEY}.calibration"
        ) from None
    motor = found.get(name) if isinstance(found, dict) else None
    if not isinstance(motor, dict) or not {"range_min", "range_max"} <= motor.keys():
        known = ", ".join(found) if isinstance(found, dict) else "a list"
        raise InputError(f"{path}: has no motor {name} with range_min and range_max; it has {known}")
    if motor.get("drive_mode"):
        raise InputError(
            f"{path}: {name}: drive_mode is {motor['drive_mode']}, which turns the sign of some servos and not of "
            f"others; expected 0, or {KEY}.range for this joint"
        )
    counts = float(motor["range_max"]) - float(motor["range_min"])
    return counts * 2 * np.pi / COUNTS
