"""The rows of the result table: one joint and signal of one cell."""

import hashlib
import json
from dataclasses import asdict, dataclass, fields

import numpy as np

from realitygap.compare.gap import Difference


@dataclass(frozen=True)
class Cell:
    """What one simulation of the matrix stands for: the key columns of the table."""

    scenario: str
    robot_revision: str
    engine: str
    engine_version: str
    ground: str
    recorded_ground: str
    step_rate: float
    solver_iterations: int | None
    overrides: str
    recording: str
    use: str


@dataclass(frozen=True)
class Row(Cell):
    """One joint and signal of one cell. A failed cell has rows with infinite gaps and the reason in `note`."""

    joint: str
    group: str
    signal: str
    unit: str
    mean_abs: float
    median_abs: float
    p95_abs: float
    max_abs: float
    noise_floor: float
    numerical_floor: float
    outcome: str
    note: str


COLUMNS = [f.name for f in fields(Row)]
CELL = [f.name for f in fields(Cell)]
EXCLUDED = "left out of the means"


LONGEST_NAME = 120
"""Bytes of the readable part of a file name: file systems take 255 in all."""


def file_name(words: str) -> str:
    """Words as a part of a file name that every file system takes."""
    safe = "".join(c if c.isalnum() or c in "-_." else "-" for c in words)
    return safe.encode("utf-8", "ignore")[:LONGEST_NAME].decode("utf-8", "ignore")


def slug(cell: Cell) -> str:
    """A file name that is the same for the same cell: readable, with a hash of the whole key."""
    key = json.dumps([str(v) for v in vars(cell).values()])
    readable = "_".join(p for p in (cell.engine, cell.recording or cell.scenario) if p)
    return f"{file_name(readable)}_{hashlib.sha256(key.encode('utf-8', 'replace')).hexdigest()[:8]}"


def row(cell: Cell, difference: Difference, noise: float, numerical: float, note: str = "") -> Row:
    """The row of one difference; floors in the unit of the difference."""
    values = difference.values if difference.values.size else np.array([np.nan])
    return Row(
        **asdict(cell),
        joint=difference.joint,
        group=difference.group,
        signal=difference.signal,
        unit=difference.unit,
        mean_abs=float(np.mean(values)),
        median_abs=float(np.median(values)),
        p95_abs=float(np.percentile(values, 95)),
        max_abs=float(np.max(values)),
        noise_floor=noise,
        numerical_floor=numerical,
        outcome="ok",
        note=note,
    )


def failed(cell: Cell, difference: Difference, noise: float, outcome: str, note: str) -> Row:
    """The row of a joint and signal that could not be simulated."""
    inf = float("inf")
    return Row(
        **asdict(cell),
        joint=difference.joint,
        group=difference.group,
        signal=difference.signal,
        unit=difference.unit,
        mean_abs=inf,
        median_abs=inf,
        p95_abs=inf,
        max_abs=inf,
        noise_floor=noise,
        numerical_floor=float("nan"),
        outcome=outcome,
        note=note,
    )


def outcome_told(outcome: str, note: str) -> str:
    """An outcome with its note, which may begin with it: "diverged at 1.2 s at knee: NaN"."""
    return note if note.startswith(f"{outcome} ") else f"{outcome}: {note}"
