"""What a diagnosis works on: motions with their noise, and how a changed plant fits them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from fnmatch import fnmatchcase

import numpy as np

from engines import Diverged, Unsupported
from harness.comparison import Motion, motions, on_first_clock
from harness.diagnose.decoys import KNOWN
from harness.diagnose.noise import local_maximum, own_noise, repetition_noise, shared_noise
from harness.drive import Array
from harness.errors import InputError
from harness.experiment import Experiment, experiments, simulate
from harness.plant import Plant
from harness.scenario_file import ScenarioFile
from harness.trace import Trace

JOINT_SIGNALS = ("position", "velocity", "effort")
SIGNALS = (*JOINT_SIGNALS, "base_position", "base_quaternion")
NEIGHBOURS = 3
"""Samples around a step transient that share its numerical floor."""
TINY = {"position": 1e-6, "velocity": 1e-5, "effort": 1e-5, "base_position": 1e-5, "base_quaternion": 1e-5}
"""The noise that is assumed at least, in SI: noise-free data would weigh rounding."""
WORST = 1e6
"""The residual of every sample of a simulation that failed."""


@dataclass(frozen=True)
class Suspect:
    """An effect at a target: `target` as a scenario says it, `indices` of the joints or links it means."""

    effect: str
    target: str | tuple[str, ...]
    indices: tuple[int, ...]


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
class Case:
    """One motion with its noise: what was measured in the mean, and how far every sample can be trusted.

    By signal: `noise` is the standard deviation per joint, `white` the sensor's own part of it in one repetition,
    `spread` that between repetitions where there were any, `floor` the numerical floor per sample, and `disturbed` how
    far disturbing torques move each sample.
    """

    name: str
    experiment: Experiment
    measured: Trace
    use: str
    noise: dict[str, Array]
    repetitions: int
    white: dict[str, Array] = field(default_factory=dict)
    spread: dict[str, Array] = field(default_factory=dict)
    floor: dict[str, Array] = field(default_factory=dict)
    disturbed: dict[str, Array] = field(default_factory=dict)

    def sigma(self, signal: str) -> Array:
        """Standard deviation of each sample: noise and numerical floor together. Shape (t, n)."""
        variance = np.broadcast_to(self.noise[signal][None, :] ** 2, self.value(signal).shape)
        for more in (self.floor.get(signal), self.disturbed.get(signal)):
            if more is not None:
                variance = variance + more**2
        return np.asarray(np.sqrt(variance))

    def value(self, signal: str) -> Array:
        """The measured signal. Shape (t, n)."""
        value = getattr(self.measured, signal)
        assert value is not None
        return np.asarray(value)


@dataclass
class Problem:
    """A scenario's motions, split into those that are fitted and those that are judged on.

    Attributes:
        file: the scenario.
        cases: every motion.
        engine: where the search simulates.
        judged: Shape (n,): which joints count.
        split: how the held-out part was chosen, in words; empty where the scenario says it.
    """

    file: ScenarioFile
    cases: list[Case]
    engine: str
    judged: np.ndarray[tuple[int], np.dtype[np.bool_]]
    split: str

    @property
    def plant(self) -> Plant:
        """The plant of the first motion, as the scenario has it."""
        return self.cases[0].experiment.plant

    def of(self, use: str) -> list[int]:
        """Indices of the cases for `train` or `held_out`."""
        return [i for i, c in enumerate(self.cases) if c.use == use]

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
        c = self.cases[case]
        e = c.experiment
        plant = self.changed_plant(changes, case)
        rate = e.scenario.physics.step_rate * finer
        trace = simulate(e.with_plant(plant), engine or self.engine, step_rate=rate).trace.at(c.measured.time)
        return {s: np.asarray(getattr(trace, s)) for s in self.signals(case)}

    def residual(self, case: int, simulated: Mapping[str, Array]) -> Array:
        """Simulated minus measured in standard deviations, all signals in one vector; 0 where nothing was measured."""
        c = self.cases[case]
        parts = []
        for signal in self.signals(case):
            delta = simulated[signal] - c.value(signal)
            if signal == "base_quaternion":
                flipped = simulated[signal] + c.value(signal)
                delta = np.where(np.sum(delta**2, axis=1) > np.sum(flipped**2, axis=1), flipped.T, delta.T).T
            scaled = delta / c.sigma(signal)
            if signal in JOINT_SIGNALS:
                scaled = scaled[:, self.judged]
            parts.append(np.nan_to_num(scaled.T, nan=0.0, posinf=WORST, neginf=-WORST).ravel())
        return np.clip(np.concatenate(parts), -WORST, WORST)

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

    def length(self, case: int) -> int:
        """Number of residuals of a motion."""
        joints = int(self.judged.sum())
        t = len(self.cases[case].measured.time)
        wide = {"base_position": 3, "base_quaternion": 4}
        return sum(t * wide.get(s, joints) for s in self.signals(case))

    def numerical_floor(self, changes: Sequence[Change], case: int) -> dict[str, Array]:
        """How far half the step moves each sample: the largest among neighbours, doubled. By signal, shape (t, n)."""
        coarse = self.simulated(changes, case)
        fine = self.simulated(changes, case, finer=2.0)
        out = {s: 2.0 * local_maximum(np.abs(coarse[s] - fine[s]), NEIGHBOURS) for s in coarse}
        if "effort" in out and self.cases[case].experiment.commands.held:
            out["effort"] = np.hypot(out["effort"], self._jumps(changes, case))
        return out

    def _jumps(self, changes: Sequence[Change], case: int) -> Array:
        """How much the effort jumps within a step of each sample: a held command moves it at once, and which side of
        the jump a sample saw is not known. Shape (t, n).
        """
        c = self.cases[case]
        plant = self.changed_plant(changes, case)
        trace = simulate(c.experiment.with_plant(plant), self.engine).trace
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
        InputError: for a scenario without recordings.
    """
    found = [m for m in motions(experiments(file)) if m.measured is not None]
    if not found:
        raise InputError(f"{file.path}: recordings.runs: found none; a diagnosis needs recordings")
    cases = [_case(m) for m in found]
    split = _split(cases)
    _hear(cases)
    pooled = _pooled(cases)
    for case in cases:
        case.noise = {signal: _noise(case, signal, pooled) for signal in case.noise}
    model = cases[0].experiment.plant.model
    recordings = file.scenario.recordings
    excluded = recordings.exclude if recordings else []
    judged = np.array([not any(fnmatchcase(n, p) for p in excluded) for n in model.joint_names], dtype=bool)
    return Problem(file, cases, engine, judged, split)


def _case(motion: Motion) -> Case:
    assert motion.measured is not None
    first = motion.experiments[0]
    noise: dict[str, Array] = {}
    spread: dict[str, Array] = {}
    traces = on_first_clock(motion.experiments, motion.shifts)
    for signal in SIGNALS:
        values = [v for t in traces if (v := getattr(t, signal)) is not None and np.isfinite(v).any()]
        if len(values) == len(traces):
            noise[signal] = np.mean([own_noise(v) for v in values], axis=0)
            if len(values) > 1:
                spread[signal] = repetition_noise(values)
    return Case(
        motion.name,
        _until(first, float(motion.measured.time[-1])),
        motion.measured,
        first.use or "",
        noise,
        len(motion.experiments),
        noise,
        spread,
    )


def _until(experiment: Experiment, end: float) -> Experiment:
    """The experiment without what comes after the last sample that is judged."""
    duration = min(experiment.duration, end - experiment.begin + 3 * experiment.scenario.timestep)
    return replace(experiment, duration=duration)


def _hear(cases: Sequence[Case]) -> None:
    """Give channels that never change, as a velocity sensor at rest, the noise of those that do."""
    joints = np.array([j.prismatic for j in cases[0].experiment.plant.model.joints], dtype=bool)
    for signal in SIGNALS:
        heard = [c.noise[signal] for c in cases if signal in c.noise]
        for alike in (joints, ~joints) if signal in JOINT_SIGNALS else (slice(None),):
            for noise, shared in zip(heard, shared_noise([n[alike] for n in heard]) if heard else [], strict=True):
                noise[alike] = shared


def _pooled(cases: Sequence[Case]) -> dict[str, Array]:
    """How much a single repetition differs from the next, by signal, over all motions that were repeated."""
    out: dict[str, Array] = {}
    for signal in SIGNALS:
        values = [c.spread[signal] ** 2 for c in cases if signal in c.spread]
        if values:
            out[signal] = np.sqrt(np.mean(values, axis=0))
    return out


def _noise(case: Case, signal: str, pooled: Mapping[str, Array]) -> Array:
    """Standard deviation of the mean of a motion's repetitions; what never changed in them is as noisy as its kind."""
    single = pooled.get(signal, case.noise[signal])
    single = np.where(single > 0, single, case.noise[signal])
    return np.asarray(np.maximum(single / np.sqrt(case.repetitions), TINY[signal]))


def _split(cases: list[Case]) -> str:
    """Mark every case as train or held_out; says how where the scenario does not."""
    uses = {c.use for c in cases}
    if "held_out" in uses and (uses & {"train", ""}):
        for c in cases:
            c.use = c.use or "train"
        return ""
    if len(cases) > 1:
        for i, c in enumerate(cases):
            c.use = "held_out" if i % 3 == 2 or (len(cases) == 2 and i == 1) else "train"
        kept = ", ".join(c.name for c in cases if c.use == "held_out")
        return f"no run was marked held_out: every third motion was kept back ({kept})"
    only = cases[0]
    time = only.measured.time
    middle = float(time[0] + 0.6 * (time[-1] - time[0]))
    later = replace(only, measured=only.measured.between(middle, np.inf), use="held_out", name=f"{only.name} (rest)")
    only.measured = only.measured.between(-np.inf, middle)
    only.use = "train"
    cases.append(later)
    return f"there is one run: it was fitted up to {middle:.2f} s and judged on the rest"
