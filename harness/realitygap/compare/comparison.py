"""Comparing one motion in one engine with what was measured: the rows of the result table."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from fnmatch import fnmatchcase
from itertools import combinations
from typing import Any

import numpy as np
import realitygap_engines as engines
from realitygap_engines import Diverged, Failed, Unsupported

from realitygap.compare.gap import JOINT_SIGNALS, Difference, box, differences, mean_trace
from realitygap.compare.row import EXCLUDED, Cell, Row, failed, row
from realitygap.files.errors import InputError
from realitygap.files.found import counted
from realitygap.recording import read_recording
from realitygap.recording.align import Repetitions, group_repetitions, noise_floor
from realitygap.scenario.file import ScenarioFile
from realitygap.simulate.excluded import check_excluded
from realitygap.simulate.experiment import Experiment, Read, experiments, simulate
from realitygap.simulate.rollout import Rollout
from realitygap.trace.sampled import Gather, sampled, stretches
from realitygap.trace.trace import Array, Trace

WHOLE = 5e8
"""Bytes of numbers up to which a simulation is kept on every step: a quarter of an hour of twenty joints at 1 kHz."""
SPARSE = 50_000
"""Samples that are kept of a longer one where nothing was measured."""
OUTCOMES: dict[type[Exception], str] = {Diverged: "diverged", Failed: "failed", Unsupported: "unsupported"}
"""What a simulation may come to in place of a motion."""


@dataclass(frozen=True)
class RepeatedMotion:
    """Repetitions of one motion under the same conditions, and what was measured in the mean.

    Attributes:
        name: of the recording, or what the repetitions' names have in common.
        experiments: the repetitions; one where the motion was recorded once or not at all.
        measured: their mean, in the window, on the first repetition's clock; None where nothing was measured.
        shifts: what to add to the first repetition's clock to get each one's [s].
        noise: (joint, signal) -> noise floor in SI.
    """

    name: str
    experiments: tuple[Experiment, ...]
    measured: Trace | None
    shifts: tuple[float, ...]
    noise: dict[tuple[str, str], float]


@dataclass
class Comparison:
    """One motion in one engine: rows for the table and, where it went well, traces.

    Attributes:
        cell: what was simulated.
        rows: of the table.
        outcome: ok, unsupported, failed or diverged.
        note: why not.
        simulated: on every step; of repetitions, their mean on the measured clock. Where that is too large, at the
            measured stamps and without the command.
        measured: in the window; the mean of repetitions.
        repetitions: every repetition's own simulation by name, on every step; empty where there is one.
        rollout: the first one, for what it cost.
        settings: what the engine really used.
        boxes: of differences that are not seen in the traces any more: signal -> joint -> as `box` tells.
    """

    cell: Cell
    rows: list[Row]
    outcome: str
    note: str = ""
    simulated: Trace | None = None
    measured: Trace | None = None
    repetitions: dict[str, Trace] = field(default_factory=dict)
    rollout: Rollout | None = None
    settings: dict[str, object] = field(default_factory=dict)
    boxes: dict[str, dict[str, list[float]]] | None = None


def motions_of(file: ScenarioFile, read: Read = read_recording) -> list[RepeatedMotion]:
    """The motions of a scenario. `read` reads the recordings.

    Raises:
        InputError: for whatever is wrong with the scenario's files, also where nothing is there that is left out.
    """
    recorded = experiments(file, read=read)
    check_excluded(file, recorded)
    return motions(recorded)


def motions(experiments: Sequence[Experiment]) -> list[RepeatedMotion]:
    """Recordings grouped into motions, each with the mean of its repetitions and their noise floor.

    Raises:
        InputError: for a window that holds no samples.
    """
    out = [RepeatedMotion(e.name, (e,), None, (0.0,), {}) for e in experiments if e.recording is None]
    recorded = [e for e in experiments if e.recording is not None]
    for group in group_repetitions(recorded):
        out.append(_motion([recorded[i] for i in group.indices], group))
    return out


def _motion(group: list[Experiment], repetitions: Repetitions) -> RepeatedMotion:
    traces = on_first_clock(group, repetitions.shifts)
    if len(traces[0].time) < 2:
        first = group[0]
        assert first.recording is not None
        whole = first.recording.trace.time
        raise InputError(
            f"{first.where}.window: found {list(first.window)}, which holds {counted(len(traces[0].time), 'sample')} "
            f"of {first.recording.path}; the recording lasts from {whole[0]:.2f} to {whole[-1]:.2f} s"
        )
    _check_different(group)
    name = repetitions.name if len(group) == 1 else f"{repetitions.name} ×{len(group)}"
    return RepeatedMotion(name, tuple(group), mean_trace(traces), repetitions.shifts, noise_floor(traces))


def _check_different(group: Sequence[Experiment]) -> None:
    """Two copies of one recording are no repetitions: their noise floor would be zero."""
    recordings = [e.recording for e in group if e.recording is not None]
    for a, b in combinations(recordings, 2):
        if a.trace.same_as(b.trace):
            raise InputError(f"{b.place}: holds the same measurement as {a.place}; expected another repetition")


def on_first_clock(group: Sequence[Experiment], shifts: Sequence[float]) -> list[Trace]:
    """What was measured in each repetition, in the window, at the first one's stamps where all have data."""
    whole = [e.recording.trace for e in group if e.recording is not None]
    first = whole[0].between(*group[0].window)
    if len(whole) == 1:
        return [first]
    clock = first.time
    for trace, shift in zip(whole, shifts, strict=True):
        clock = clock[(clock + shift >= trace.time[0]) & (clock + shift <= trace.time[-1])]
    return [replace(t.at(clock + shift), time=clock) for t, shift in zip(whole, shifts, strict=True)]


def cell_of(motion: RepeatedMotion, engine: str, revision: str = "") -> Cell:
    """The key columns of one motion in one engine."""
    scenario = motion.experiments[0].scenario
    recordings = scenario.recordings
    return Cell(
        scenario=scenario.name,
        robot_revision=revision or scenario.robot.urdf.rsplit("/", 1)[-1].removesuffix(".urdf"),
        engine=engine,
        engine_version=engines.load(engine).version,
        ground=scenario.ground_name,
        recorded_ground=(recordings.ground or "") if recordings else "",
        step_rate=scenario.physics.step_rate,
        solver_iterations=scenario.physics.solver_iterations,
        overrides=motion.experiments[0].overrides,
        recording=motion.name if motion.measured is not None else "",
        use=motion.experiments[0].use or "",
    )


def whole_size(motion: RepeatedMotion) -> float:
    """Bytes of numbers of a motion's traces, simulated on every step and measured."""
    out = 0.0
    for e in motion.experiments:
        steps = 0.0 if e.followed is not None else e.duration * e.scenario.physics.step_rate
        rows = steps + (0 if e.recording is None else len(e.recording.trace.time))
        out += rows * 8 * (4 * len(e.plant.model.joints) + (13 if e.plant.model.floating else 0))
    return out


def compare(
    motion: RepeatedMotion, engine: str, *, floors: bool = True, revision: str = "", whole: bool = False
) -> Comparison:
    """Simulate a motion and its numerical floor; a failure becomes rows that say what happened.

    Args:
        motion: what is simulated.
        engine: in which engine.
        floors: whether to simulate again with half the step for the numerical floor.
        revision: the robot's revision in tables (default: the name of its URDF).
        whole: whether every step is kept, however many they are.
    """
    whole = whole or whole_size(motion) <= WHOLE
    cell = cell_of(motion, engine, revision)
    excluded = scenario_excluded(motion)
    try:
        rollouts = _simulated(motion, engine, 1.0, whole=whole)
        mean = _mean(motion, rollouts)
        numerical = _numerical_floors(motion, engine, mean) if floors and motion.measured is not None else {}
    except tuple(OUTCOMES) as error:
        return failure(cell, motion, OUTCOMES[type(error)], str(error))
    names = [e.name for e in motion.experiments]
    each = {n: r.trace for n, r in zip(names, rollouts, strict=True)} if len(rollouts) > 1 else {}
    first = rollouts[0]
    done = Comparison(cell, [], "ok", "", mean, motion.measured, each, first, first.settings)
    if motion.measured is None:
        return done
    model = motion.experiments[0].plant.model
    done.boxes = None if whole else {}
    for d in _judged(motion, differences(model, mean, motion.measured)):
        note = EXCLUDED if any(fnmatchcase(d.joint, p) for p in excluded) else ""
        if d.values.size:
            done.rows.append(row(cell, d, _noise(motion, d), numerical.get((d.joint, d.signal), float("nan")), note))
        if d.values.size and done.boxes is not None:
            done.boxes.setdefault(d.signal, {})[d.joint] = box(d.values)
    return done


def _numerical_floors(motion: RepeatedMotion, engine: str, mean: Trace) -> dict[tuple[str, str], float]:
    """How far the mean motion moves with half the step, by joint and signal, in the units of the table."""
    measured, model = motion.measured, motion.experiments[0].plant.model
    assert measured is not None
    if len(motion.experiments) > 1:
        fine = _mean(motion, _simulated(motion, engine, 2.0, whole=False))
        return {(d.joint, d.signal): float(np.mean(d.values)) for d in differences(model, mean, fine)}
    total: dict[tuple[str, str], float] = {}
    count: dict[tuple[str, str], int] = {}

    def gather(parts: Iterable[Trace], time: Array) -> Trace:
        """Add up how far every part has moved: all of them at once would be as large as the motion again."""
        for rows, fine in stretches(parts, time):
            there = mean.rows(rows) if mean.time is time else mean.at(fine.time)
            for d in differences(model, replace(there, time=fine.time), fine):
                key = d.joint, d.signal
                total[key] = total.get(key, 0.0) + float(np.sum(d.values))
                count[key] = count.get(key, 0) + len(d.values)
        return Trace(time[:0], tuple(model.joint_names))

    _simulated(motion, engine, 2.0, whole=False, gather=gather)
    return {key: total[key] / count[key] if count[key] else float("nan") for key in total}


def failure(cell: Cell, motion: RepeatedMotion, outcome: str, note: str) -> Comparison:
    """A cell that could not be simulated: rows that say what happened, with infinite gaps."""
    rows = [failed(cell, d, _noise(motion, d), outcome, note) for d in _expected(motion)]
    return Comparison(cell, rows, outcome, note, measured=motion.measured)


def scenario_excluded(motion: RepeatedMotion) -> list[str]:
    """Patterns of the joints that the scenario leaves out of the means."""
    recordings = motion.experiments[0].scenario.recordings
    return recordings.exclude if recordings else []


def _simulated(
    motion: RepeatedMotion, engine: str, finer: float, *, whole: bool, gather: Gather = sampled
) -> list[Rollout]:
    """Every repetition simulated, with `finer` times the scenario's step rate; not whole: at the measured stamps."""
    out = []
    for e, shift in zip(motion.experiments, motion.shifts, strict=True):
        at = None
        if not whole and motion.measured is not None:
            at = motion.measured.time if len(motion.experiments) == 1 else motion.measured.time + shift
        elif not whole:
            at = e.begin + np.linspace(0.0, e.duration, SPARSE)
        out.append(simulate(e, engine, step_rate=e.scenario.physics.step_rate * finer, at=at, gather=gather))
    return out


def _mean(motion: RepeatedMotion, rollouts: Sequence[Rollout]) -> Trace:
    """The trace of the one repetition; of several, their mean on the measured clock."""
    if motion.measured is None or len(rollouts) == 1:
        return rollouts[0].trace
    clock = motion.measured.time
    parts = [replace(r.trace.at(clock + s), time=clock) for r, s in zip(rollouts, motion.shifts, strict=True)]
    return mean_trace(parts)


def _noise(motion: RepeatedMotion, difference: Difference) -> float:
    return motion.noise.get((difference.joint, difference.signal), float("nan")) * difference.scale


def _expected(motion: RepeatedMotion) -> Iterator[Difference]:
    """The differences that a cell would have had: those of the measurement with itself."""
    if motion.measured is None:
        return iter(())
    model = motion.experiments[0].plant.model
    measured = motion.measured
    names = model.joint_names
    order = [measured.index(n) for n in names]
    twin: dict[str, Any] = {s: None if (v := getattr(measured, s)) is None else v[:, order] for s in JOINT_SIGNALS}
    return _judged(motion, differences(model, replace(measured, joints=tuple(names), **twin), measured))


def _judged(motion: RepeatedMotion, found: Iterable[Difference]) -> Iterator[Difference]:
    """What a motion is judged by: of one that is followed the effort, as its positions and velocities are given."""
    followed = motion.experiments[0].followed is not None
    return (d for d in found if d.signal == "effort" or not followed)
