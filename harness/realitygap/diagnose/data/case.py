"""A motion as a diagnosis sees it: what was measured, and how far every sample of it can be trusted."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from realitygap.compare.comparison import RepeatedMotion, on_first_clock
from realitygap.diagnose.data.noise import repetition_noise, shared_noise
from realitygap.recording.noise import own_noise
from realitygap.robot.drive import Array
from realitygap.simulate.experiment import Experiment
from realitygap.trace.trace import Trace

JOINT_SIGNALS = ("position", "velocity", "effort")
SIGNALS = (*JOINT_SIGNALS, "base_position", "base_quaternion")
TINY = {"position": 1e-6, "velocity": 1e-5, "effort": 1e-5, "base_position": 1e-5, "base_quaternion": 1e-5}
"""The noise that is assumed at least, in SI: noise-free data would weigh rounding."""


@dataclass(frozen=True)
class Case:
    """One motion with its noise: what was measured in the mean, and how far its sensors can be trusted.

    By signal and joint: `noise` is the standard deviation of the mean of the repetitions, `white` the sensor's own part
    of it in one repetition, `spread` that between repetitions where there were any. `recorded` says how often the
    motion was: a repetition that the others do not reproduce is a case of its own. `windows` are its pieces of a
    `length` [s] where it is simulated in pieces.
    """

    name: str
    experiment: Experiment
    measured: Trace
    use: str
    noise: dict[str, Array]
    repetitions: int
    white: dict[str, Array] = field(default_factory=dict)
    spread: dict[str, Array] = field(default_factory=dict)
    recorded: int = 1
    windows: tuple[Experiment, ...] = ()
    length: float = np.inf

    @property
    def pieces(self) -> tuple[Experiment, ...]:
        """What is simulated of it: its windows, or all of it at once."""
        return self.windows or (self.experiment,)

    def value(self, signal: str) -> Array:
        """The measured signal. Shape (t, n)."""
        value = getattr(self.measured, signal)
        assert value is not None
        return np.asarray(value)


def cases_of(motions: Sequence[RepeatedMotion]) -> list[Case]:
    """The recorded motions, each with its noise."""
    cases = [_case(m) for m in motions]
    _hear(cases)
    pooled = _pooled(cases)
    return [replace(case, noise={signal: _noise(case, signal, pooled) for signal in case.noise}) for case in cases]


def _case(motion: RepeatedMotion) -> Case:
    assert motion.measured is not None
    first = motion.experiments[0]
    noise: dict[str, Array] = {}
    spread: dict[str, Array] = {}
    traces = on_first_clock(motion.experiments, motion.shifts)
    for signal in SIGNALS if first.followed is None else ("effort",):  # a motion that is followed is no answer
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
    linear = np.array([j.prismatic for j in cases[0].experiment.plant.model.joints], dtype=bool)
    for signal in SIGNALS:
        heard = [c.noise[signal] for c in cases if signal in c.noise]
        for alike in (linear, ~linear) if signal in JOINT_SIGNALS else (slice(None),):
            for noise, shared in zip(heard, shared_noise([n[alike] for n in heard]), strict=True):
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
