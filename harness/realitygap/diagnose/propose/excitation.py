"""Motions: segments one behind the other under one condition, and what a diagnosis would make of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from realitygap.diagnose.data.case import Case
from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.likelihood.floors import Floors
from realitygap.diagnose.propose.condition import Condition
from realitygap.diagnose.propose.segments import Segment
from realitygap.recording import Recording
from realitygap.robot.drive import Array
from realitygap.simulate.commands import Commands
from realitygap.simulate.experiment import Experiment
from realitygap.trace.trace import Trace

BEFORE = 1.0
"""How long the robot has been in the pose before a motion begins [s]."""
USE = "proposed"
FASTEST, SLOWEST = 1e-3, 0.02
"""Bounds of the period of the commands [s]."""


@dataclass(frozen=True)
class Excitation:
    """Segments one behind the other.

    Attributes:
        name: of its files.
        segments: in their order.
        condition: under which it is recorded.
        period: of the commands [s].
    """

    name: str
    segments: tuple[Segment, ...]
    condition: Condition
    period: float

    @property
    def value(self) -> Array:
        """Commands, NaN where a servo is off; the pose at first. Shape (m, n)."""
        return np.concatenate([self.path[:1], *(s.commands() for s in self.segments)])

    @property
    def path(self) -> Array:
        """The same as if no servo was off: it begins in the pose in which every segment ends. Shape (m, n)."""
        return np.concatenate([self.segments[-1].value[-1:], *(s.value for s in self.segments)])

    @property
    def time(self) -> Array:
        """When each command is sent [s]. Shape (m,)."""
        return self.period * np.arange(1 + sum(len(s.value) for s in self.segments), dtype=float)

    @property
    def seconds(self) -> float:
        """How long it takes."""
        return float(self.time[-1])


def period_of(problem: Problem) -> float:
    """The period of the recorded commands [s], as far as a proposed motion keeps to it."""
    times = [c.experiment.commands.time for c in problem.cases]
    periods = [float(np.median(np.diff(t))) for t in times if len(t) > 2]
    return float(np.clip(np.median(periods), FASTEST, SLOWEST)) if periods else SLOWEST / 2


def pose_of(problem: Problem, pose: dict[str, float]) -> Array:
    """Where motions start and end: as the owner says, or where the recordings' first commands are. Shape (n,)."""
    names = problem.plant.model.joint_names
    firsts = []
    for case in problem.cases:
        told = case.experiment.commands.value
        good = told[np.isfinite(told).all(axis=1)]
        firsts.append(good[0] if len(good) else case.value("position")[0])
    home = np.median(firsts, axis=0) if firsts else np.zeros(len(names))
    return np.array([pose.get(name, float(home[i])) for i, name in enumerate(names)])


def experiment_of(motion: Excitation, like: Experiment | None = None) -> Experiment:
    """The simulation of a motion; it begins before the motion, with the readings in the pose, so that the robot is at
    rest. `like` is what was recorded before, if anything was.
    """
    value, condition = motion.value, motion.condition
    time = np.concatenate([[-BEFORE], motion.time])
    told = np.concatenate([value[:1], value])
    robot = condition.scenario.robot.model_copy(update={"start": "recording"})
    still = np.tile(value[0], (2, 1))
    names = tuple(condition.plant.model.joint_names)
    trace = Trace(np.array([-BEFORE, 0.0]), names, still, np.zeros_like(still))
    kind, supply = "position", np.zeros(0)
    if like is not None and like.recording is not None:
        kind, supply = like.recording.command_kind or kind, like.recording.supply
    volts = np.full(min(len(supply), 1), np.median(supply) if len(supply) else 0.0)
    recording = Recording(Path(motion.name), trace, time, told, kind, np.zeros(len(volts)), volts)
    return Experiment(
        name=motion.name,
        scenario=condition.scenario.model_copy(update={"robot": robot}),
        plant=condition.plant,
        recording=recording,
        commands=Commands(time + BEFORE, told, like is None or like.commands.held),
        begin=-BEFORE,
        duration=BEFORE + motion.seconds,
        use=USE,
    )


def with_motions(problem: Problem, motions: Sequence[Excitation]) -> Problem:
    """The problem with motions as further cases, behind its own; what would be measured is not known."""
    like = problem.cases[0]
    rate = (len(like.measured.time) - 1) / (like.measured.time[-1] - like.measured.time[0])
    noise = {s: single(problem, s) for s in problem.joint_signals(0)}
    cases = [case_of(m, experiment_of(m, like.experiment), noise, rate) for m in motions]
    return replace(problem, cases=(*problem.cases, *cases))


def case_of(motion: Excitation, experiment: Experiment, noise: dict[str, Array], rate: float) -> Case:
    """A motion as it would be recorded, so many times a second [Hz], with this noise by signal (n,)."""
    time = np.arange(0.0, motion.seconds, 1.0 / rate)
    names = tuple(motion.condition.plant.model.joint_names)
    nothing = {s: np.zeros((len(time), len(names))) for s in noise}
    empty = Trace(time, names, nothing.get("position"), nothing.get("velocity"), nothing.get("effort"))
    return Case(motion.name, experiment, empty, experiment.use or USE, noise, 1, noise)


def single(problem: Problem, signal: str) -> Array:
    """The noise of one repetition, over all motions. Shape (n,)."""
    values = [c.noise[signal] * np.sqrt(c.repetitions) for c in problem.cases if signal in c.noise]
    return np.asarray(np.median(values, axis=0))


def expected_floors(problem: Problem, floors: Floors, own: int) -> Floors:
    """The floors of a problem whose further cases were not measured: as large as those of its first `own` cases.

    Quick, for what is looked at in passing: `measure` simulates disturbances and numerics of every motion.
    """
    last = [dict[str, Array]() for _ in problem.cases[own:]]
    noise = [dict[str, Array]() for _ in problem.cases[own:]]
    for slow, heard, case in zip(last, noise, problem.cases[own:], strict=True):
        for signal in case.noise:
            far = [
                np.sqrt(np.mean(floors.slow[c][signal] ** 2, axis=0) * problem.cases[c].repetitions)
                for c in range(own)
                if signal in floors.slow[c]
            ]
            slow[signal] = np.tile(np.sqrt(np.mean(np.square(far), axis=0)), (len(case.measured.time), 1))
            own_noise = [
                floors.noise[c][signal] * np.sqrt(problem.cases[c].repetitions)
                for c in range(own)
                if signal in floors.noise[c]
            ]
            heard[signal] = np.median(own_noise, axis=0)
    coarse = (*floors.coarse[:own], *[max(floors.coarse[:own])] * len(last))
    return Floors((*floors.noise[:own], *noise), (*floors.slow[:own], *last), coarse, floors.torque)
