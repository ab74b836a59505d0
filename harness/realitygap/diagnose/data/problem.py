"""What a diagnosis works on: motions with their noise, split into those that are fitted and those kept to judge on."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from typing import Any

import numpy as np
from numpy.typing import NDArray

from realitygap.compare.comparison import motions_of
from realitygap.diagnose.data.case import JOINT_SIGNALS, SIGNALS, Case, cases_of
from realitygap.diagnose.data.changes import Change, changed
from realitygap.diagnose.data.split import split
from realitygap.diagnose.data.windowed import windowed
from realitygap.files.errors import InputError
from realitygap.recording.frames import rotation_vector
from realitygap.robot.drive import EFFORT, POSITION, TORQUE, Array
from realitygap.robot.effects.place import place
from realitygap.robot.plant import Plant, build_plant
from realitygap.scenario.file import ScenarioFile

Signals = Mapping[str, Array]
"""Simulated signals at the measured stamps, by name. Shape (t, n) each."""


@dataclass(frozen=True)
class Problem:
    """A scenario's motions.

    Attributes:
        file: the scenario.
        plant: as the scenario has it; single runs may differ from it.
        cases: every motion.
        engine: where the search simulates.
        judged: Shape (n,): which joints count.
        split: how the held-out part was chosen, in words; empty where the scenario says it.
        notes: sentences on motions that are judged over windows.
    """

    file: ScenarioFile
    plant: Plant
    cases: tuple[Case, ...]
    engine: str
    judged: NDArray[np.bool_]
    split: str
    notes: tuple[str, ...] = ()

    def of(self, use: str) -> list[int]:
        """Indices of the cases for `train` or `held_out`."""
        return [i for i, c in enumerate(self.cases) if c.use == use]

    @property
    def followed(self) -> bool:
        """Whether motions are followed, and not driven."""
        return self.cases[0].experiment.followed is not None

    @property
    def repeated(self) -> bool:
        """Whether any motion was repeated, so that it is known how much one repetition differs from the next."""
        return any(case.spread for case in self.cases)

    def signals(self, case: int) -> list[str]:
        """The signals that are compared."""
        return [s for s in SIGNALS if s in self.cases[case].noise]

    def joint_signals(self, case: int) -> list[str]:
        """The signals of joints among them."""
        return [s for s in self.signals(case) if s in JOINT_SIGNALS]

    def measured(self, cases: Sequence[int], signal: str, joint: int) -> bool:
        """Whether a signal of a joint was measured in some of these motions."""
        return any(bool(np.isfinite(self.cases[i].value(signal)[:, joint]).any()) for i in cases)

    def changed_plant(self, changes: Sequence[Change], case: int) -> Plant:
        """The plant of one motion with changes."""
        return changed(self.cases[case].experiment.plant, changes, self.plant)

    def columns(self, signal: str, value: Array) -> Array:
        """Of joints, those that are judged. Shape (t, n) -> (t, k)."""
        return value[:, self.judged] if signal in JOINT_SIGNALS else value

    def delta(self, case: int, signal: str, simulated: Signals) -> Array:
        """Simulated minus measured, of what is judged; NaN where nothing was measured. Shape (t, k).

        Of orientations the rotation between them [rad], in the axes of the measured one: k is 3.
        """
        return self.difference(signal, self.cases[case].value(signal), simulated[signal])

    def difference(self, signal: str, a: Array, b: Array) -> Array:
        """b minus a, of what is judged, as `delta`. Shapes (t, n) -> (t, k)."""
        return rotation_vector(a, b) if signal == "base_quaternion" else self.columns(signal, b - a)

    def deviation(self, signal: str, sigma: Array) -> Array:
        """Standard deviations of a `delta` from those of its signal. Shape (t, n) -> (t, k).

        Quaternions that differ by a small rotation are half of it apart; it is as uncertain about one axis as another.
        """
        if signal != "base_quaternion":
            return self.columns(signal, sigma)
        each = 2.0 * np.sqrt(np.sum(sigma**2, axis=1) / 3.0)
        return np.repeat(each[:, None], 3, axis=1)


def build_problem(file: ScenarioFile, engine: str) -> Problem:
    """The problem that a scenario states.

    Raises:
        InputError: for a scenario without recordings to fit and to judge on.
    """
    found = [m for m in motions_of(file) if m.measured is not None]
    if not found:
        raise InputError(f"{file.path}: recordings.runs: found none; a diagnosis needs recordings")
    plant = place(build_plant(file), file.scenario.effects)
    recordings = file.scenario.recordings
    excluded = recordings.exclude if recordings else []
    judged = np.array([not any(fnmatchcase(n, p) for p in excluded) for n in plant.model.joint_names], dtype=bool)
    if len(judged) and not judged.any():
        raise InputError(f"{file.path}: recordings.exclude: {excluded} leaves no joint; expected some to judge on")
    cases, said = split(file, cases_of(found), found)
    cases, notes = windowed(cases, found, engine)
    train = [c for c in cases if c.use == "train"]
    plant.reached, plant.travelled, plant.exerted = reached(train), travelled(train), exerted(train)
    plant.lagged = lagged(train)
    return Problem(file, plant, tuple(cases), engine, judged, said, tuple(notes))


FAST = 0.99
"""A joint reached the speed that it exceeds in the rest of its samples: the very largest is noise."""


def reached(cases: Sequence[Case]) -> Array:
    """How fast each joint went in any motion [rad/s or m/s], 0 for one that was not recorded. Shape (n,)."""
    return _most([_speed(case) for case in cases], lambda speed: np.quantile(speed, FAST))


def travelled(cases: Sequence[Case]) -> Array:
    """The widest range that each joint moved over in one motion [rad or m], 0 where none was recorded. Shape (n,)."""
    return _most([case.value("position") for case in cases], np.ptp)


def lagged(cases: Sequence[Case]) -> Array:
    """How far each joint was from its position command at most [rad or m], 0 where it had none. Shape (n,)."""
    return _most([_error(case) for case in cases], np.max)


def exerted(cases: Sequence[Case]) -> Array:
    """The most that each joint's motor gave in any motion [N·m or N], as measured or told; 0 where neither is known.
    Shape (n,).
    """
    return _most([_effort(case) for case in cases], lambda effort: np.max(effort))


def _effort(case: Case) -> Array:
    """How much the motors gave, NaN where it is not known. Shape (t, n)."""
    commands, drive = case.experiment.commands.value, case.experiment.plant.drive
    if "effort" in case.noise:
        return np.abs(case.value("effort"))
    gain = np.where(drive["kind"] == TORQUE, drive["gain"], 1.0)
    return np.where(drive["meaning"] == EFFORT, np.abs(gain * commands), np.nan)


def _error(case: Case) -> Array:
    """How far the joints were from their position commands, NaN where they had none. Shape (t, n)."""
    commands, position = case.experiment.commands, case.value("position")
    last = np.searchsorted(commands.time, case.measured.time, side="right") - 1
    told = commands.value[np.maximum(last, 0)]
    return np.where(case.experiment.plant.drive["meaning"] == POSITION, np.abs(told - position), np.nan)


def _speed(case: Case) -> Array:
    """How fast each joint went. Shape (t, n)."""
    velocity = case.measured.velocity
    if velocity is None:
        velocity = np.gradient(case.value("position"), case.measured.time, axis=0)
    return np.abs(velocity)


def _most(motions: Sequence[Array], of: Callable[[Array], Any]) -> Array:
    """The most of a figure of what is known of each joint in a motion, of all motions (t, n); 0 where nothing is known
    of it. Shape (n,).
    """
    known = [[column[np.isfinite(column)] for column in values.T] for values in motions]
    return np.asarray(np.max([[float(of(v)) if len(v) else 0.0 for v in joints] for joints in known], axis=0))
