"""What a diagnosis works on: motions with their noise, and how a changed plant fits them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from fnmatch import fnmatchcase

import numpy as np
from realitygap_engines import Diverged, Unsupported

from realitygap.compare.comparison import motions_of
from realitygap.diagnose.data.case import JOINT_SIGNALS, SIGNALS, Case, cases_of
from realitygap.diagnose.data.decoys import KNOWN
from realitygap.diagnose.data.noise import local_maximum
from realitygap.diagnose.data.split import split
from realitygap.files.errors import InputError
from realitygap.robot.drive import Array
from realitygap.robot.effects.place import place
from realitygap.robot.plant import Plant, build_plant
from realitygap.scenario.file import ScenarioFile
from realitygap.simulate.experiment import simulate
from realitygap.trace.trace import Trace

NEIGHBOURS = 3
"""Samples around a step transient that share its numerical floor."""
WORST = 1e6
"""The residual of every sample of a simulation that failed."""


@dataclass(frozen=True)
class Suspect:
    """An effect at a target: `target` as a scenario says it, `indices` of the joints or links it means, and the name of
    the `servo`, where they are all joints of one.
    """

    effect: str
    target: str | tuple[str, ...]
    indices: tuple[int, ...]
    servo: str = field(default="", compare=False)

    @property
    def where(self) -> str:
        """The target for people."""
        if isinstance(self.target, str):
            return self.target
        return f"the {len(self.target)} joints of servo {self.servo}" if self.servo else ", ".join(self.target)


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


@dataclass
class Problem:
    """A scenario's motions, split into those that are fitted and those that are judged on.

    Attributes:
        file: the scenario.
        plant: as the scenario has it; single runs may differ from it.
        cases: every motion.
        engine: where the search simulates.
        judged: Shape (n,): which joints count.
        split: how the held-out part was chosen, in words; empty where the scenario says it.
    """

    file: ScenarioFile
    plant: Plant
    cases: list[Case]
    engine: str
    judged: np.ndarray[tuple[int], np.dtype[np.bool_]]
    split: str

    def of(self, use: str) -> list[int]:
        """Indices of the cases for `train` or `held_out`."""
        return [i for i, c in enumerate(self.cases) if c.use == use]

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

    def changed_plant(self, changes: Sequence[Change], case: int) -> Plant:
        """The plant of one motion with changes."""
        return changed(self.cases[case].experiment.plant, changes, self.plant)

    def simulated(
        self, changes: Sequence[Change], case: int, *, engine: str | None = None, finer: float = 1.0
    ) -> dict[str, Array]:
        """The signals of one motion with a changed plant, at the measured stamps.

        Raises:
            Unsupported, Diverged: as the engine says.
        """
        return self._sampled(self._trace(changes, case, engine or self.engine, finer), case)

    def simulations(self, changes: Sequence[Change], cases: Iterable[int]) -> dict[int, dict[str, Array]]:
        """The signals of those motions that can be simulated with a changed plant, by case."""
        out = {}
        for i in cases:
            with suppress(Diverged, Unsupported):
                out[i] = self.simulated(changes, i)
        return out

    def _trace(self, changes: Sequence[Change], case: int, engine: str, finer: float) -> Trace:
        e = self.cases[case].experiment.with_plant(self.changed_plant(changes, case))
        return simulate(e, engine, step_rate=e.scenario.physics.step_rate * finer).trace

    def _sampled(self, trace: Trace, case: int) -> dict[str, Array]:
        at = trace.at(self.cases[case].measured.time)
        return {s: np.asarray(getattr(at, s)) for s in self.signals(case)}

    def residual(self, case: int, simulated: Mapping[str, Array]) -> Array:
        """Simulated minus measured in standard deviations, all signals in one vector; 0 where nothing was measured."""
        scaled = [self.scaled(case, signal, simulated) for signal in self.signals(case)]
        parts = [np.nan_to_num(s.T, nan=0.0, posinf=WORST, neginf=-WORST).ravel() for s in scaled]
        return np.clip(np.concatenate(parts), -WORST, WORST)

    def scaled(self, case: int, signal: str, simulated: Mapping[str, Array]) -> Array:
        """Simulated minus measured in standard deviations, of one signal; NaN where nothing was measured.

        Shape (t, n): of joints, those that are judged.
        """
        c = self.cases[case]
        delta = simulated[signal] - c.value(signal)
        if signal == "base_quaternion":
            flipped = simulated[signal] + c.value(signal)
            delta = np.where(np.sum(delta**2, axis=1) > np.sum(flipped**2, axis=1), flipped.T, delta.T).T
        out = np.asarray(delta / c.sigma(signal))
        return out[:, self.judged] if signal in JOINT_SIGNALS else out

    def levels(self, case: int, misfit: float) -> Array:
        """What to multiply a motion's residual by where no model comes closer than `misfit` floors.

        What no model explains is noise of its own kind, `misfit` times the sensors': beside it the numerical floor of a
        sample hardly matters, and all samples count nearly alike. 1 everywhere for a misfit of 1.
        """
        c = self.cases[case]
        parts = []
        for signal in self.signals(case):
            sigma = c.sigma(signal)
            level = misfit * sigma / np.sqrt(sigma**2 + (misfit**2 - 1.0) * c.noise[signal] ** 2)
            parts.append((level[:, self.judged] if signal in JOINT_SIGNALS else level).T.ravel())
        return np.concatenate(parts)

    def residuals(
        self, changes: Sequence[Change], case: int, *, engine: str | None = None, finer: float = 1.0
    ) -> Array:
        """The residual of one motion with a changed plant; a failed simulation is very wrong everywhere."""
        try:
            return self.residual(case, self.simulated(changes, case, engine=engine, finer=finer))
        except (Diverged, Unsupported):
            return np.full(self.length(case), WORST)

    def coarse_residuals(self, changes: Sequence[Change], case: int) -> Array:
        """The same at the least step rate that is faithful: for derivatives and first tries."""
        return self.residuals(changes, case, finer=self.cases[case].coarse)

    def length(self, case: int) -> int:
        """Number of residuals of a motion."""
        joints = int(self.judged.sum())
        t = len(self.cases[case].measured.time)
        wide = {"base_position": 3, "base_quaternion": 4}
        return sum(t * wide.get(s, joints) for s in self.signals(case))

    def numerical_floor(self, changes: Sequence[Change], case: int) -> dict[str, Array]:
        """How far half the step moves each sample: the largest among neighbours, doubled. By signal, shape (t, n)."""
        trace = self._trace(changes, case, self.engine, 1.0)
        coarse, fine = self._sampled(trace, case), self.simulated(changes, case, finer=2.0)
        out = {s: 2.0 * local_maximum(np.abs(coarse[s] - fine[s]), NEIGHBOURS) for s in coarse}
        if "effort" in out and self.cases[case].experiment.commands.held:
            out["effort"] = np.hypot(out["effort"], self._jumps(trace, case))
        return out

    def _jumps(self, trace: Trace, case: int) -> Array:
        """How much the effort jumps within a step of each sample: a held command moves it at once, and which side of
        the jump a sample saw is not known. Shape (t, n).
        """
        c = self.cases[case]
        h = c.experiment.scenario.timestep
        before, after = (np.asarray(trace.at(c.measured.time + d).effort) for d in (-h, h))
        return np.asarray(np.abs(after - before))


def changed(plant: Plant, changes: Sequence[Change], reference: Plant) -> Plant:
    """A plant with effects changed.

    Where a run's own value differs from that of the reference (another gain, another load), a change keeps its ratio
    to the reference: a gain that is 10 % low is 10 % low in every run.
    """
    out = plant.copy()
    for change in changes:
        effect = KNOWN[change.suspect.effect]
        indices = list(change.suspect.indices)
        for i in indices:
            here, there = effect.own(plant, i), effect.own(reference, i)
            values = {}
            for name, value in change.values:
                own, first = here.get(name), there.get(name)
                if effect.parameter(name).absent is None and own is not None and first and own != first:
                    value = value * own / first
                values[name] = value
            if len(indices) > 1 and values == change.parameters:
                effect.apply(out, indices, values)
                break
            effect.apply(out, [i], values)
    return out


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
    cases = cases_of(found)
    return Problem(file, plant, cases, engine, judged, split(file, cases, found))
