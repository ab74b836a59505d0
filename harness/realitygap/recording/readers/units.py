"""From the units of a table or a bag to SI."""

from collections.abc import Sequence
from dataclasses import replace
from fnmatch import fnmatchcase
from pathlib import Path

import numpy as np

from realitygap.files.errors import InputError
from realitygap.recording.streams import Request, Samples
from realitygap.scenario.schema import Lengths, Rate, Rates
from realitygap.trace.trace import Array

SECONDS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
RPM = 2.0 * np.pi / 60.0
"""rad/s per revolution a minute."""
FACTORS = {
    "rad": 1.0,
    "mrad": 1e-3,
    "deg": np.pi / 180,
    "mdeg": np.pi / 180e3,
    "rev": 2.0 * np.pi,
    "m": 1.0,
    "cm": 1e-2,
    "mm": 1e-3,
    "rpm": RPM,
}
"""SI per unit, of a velocity per unit and second."""
RATES_AND_ANGLES = {"position", "velocity"}
"""What a bag may hold in other units; efforts are in SI."""


def unit_of(units: Lengths | Rates, joint: str) -> Rate | None:
    """The unit of a joint: that of the first pattern that matches; None where none does."""
    return units if isinstance(units, str) else next((u for p, u in units.items() if fnmatchcase(joint, p)), None)


def joint_factors(units: Lengths | Rates, joints: Sequence[str], key: str, file: Path) -> Array:
    """SI per recorded unit of every joint; the first pattern that matches counts. Shape (n,).

    Raises:
        InputError: for a joint that no pattern matches.
    """
    out = []
    for joint in joints:
        found = unit_of(units, joint)
        if found is None:
            raise InputError(f"{file}: {key}: no pattern matches joint {joint}; expected a unit for every joint")
        out.append(FACTORS[found])
    return np.array(out)


def in_si(samples: Samples, role: str, request: Request) -> Samples:
    """A stream of a bag in SI units, as a state or a command; others are in SI.

    Raises:
        InputError: for a joint that no pattern matches.
    """
    signals = dict(samples.signals)
    for signal in RATES_AND_ANGLES & signals.keys() if samples.joints and role in ("state", "command") else ():
        factors = _factors("command" if role == "command" else signal, request)
        if (factors != 1.0).any():
            signals[signal] = factors * signals[signal]
    return replace(samples, signals=signals)


def as_commanded(state: Samples, request: Request) -> Samples:
    """A state of a bag with its positions in the units of the commands."""
    factors = _factors("position", request) / _factors("command", request)
    if "position" not in state.signals or (factors == 1.0).all():
        return state
    return replace(state, signals={**state.signals, "position": factors * state.signals["position"]})


def _factors(quantity: str, request: Request) -> Array:
    units, key = getattr(request.recordings.columns.units, quantity), f"recordings.columns.units.{quantity}"
    return joint_factors(units, request.joints, key, request.file)
