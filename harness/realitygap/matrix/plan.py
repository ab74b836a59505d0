"""From a matrix file to the cells that are to be computed, each with its input read and its key known."""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

import realitygap_engines as engines
from realitygap_engines.model.robot import Mimic

from realitygap.compare.comparison import RepeatedMotion, motions
from realitygap.compare.row import slug
from realitygap.files.errors import InputError
from realitygap.matrix.digest import Digest, code_version
from realitygap.matrix.left_out import check_left_out, left_out
from realitygap.matrix.matrix_file import NAMED_AXES, MatrixFile
from realitygap.matrix.task import Task
from realitygap.matrix.variant import variant_of
from realitygap.recording import Recording, read_recording
from realitygap.recording.streams import request_of
from realitygap.scenario.file import ScenarioFile
from realitygap.scenario.schema import Scenario
from realitygap.simulate.excluded import check_excluded
from realitygap.simulate.experiment import Experiment, experiments


class Reader:
    """Reads every recording once."""

    def __init__(self) -> None:
        self._known: dict[str, Recording] = {}

    def __call__(
        self,
        path: Path,
        scenario: Scenario,
        joints: Sequence[str],
        *,
        file: Path,
        mimics: Mapping[str, Mimic] | None = None,
        limits: Mapping[str, tuple[float, float]] | None = None,
    ) -> Recording:
        """As `read_recording`."""
        key = repr((path, request_of(scenario, tuple(joints), file), mimics, limits))
        if key not in self._known:
            self._known[key] = read_recording(path, scenario, joints, file=file, mimics=mimics, limits=limits)
        return self._known[key]


def plan(matrix: MatrixFile, read: Reader | None = None) -> list[Task]:
    """The cells of a matrix, in the order in which a person looks for them. `read` reads the recordings.

    Raises:
        InputError: for whatever is wrong with the matrix, its scenarios or their files.
    """
    engine_names = matrix.engine_names()
    digest, read = Digest(), read or Reader()
    tasks: dict[str, Task] = {}
    known: dict[int, tuple[Scenario, str]] = {}
    recorded: set[str] = set()
    for file in matrix.scenarios:
        variants = list(_variants(matrix, file, read))
        check_excluded(file, [e for _, _, (_, found) in variants for motion in found for e in motion.experiments])
        for axes, revision, found in variants:
            recorded |= {motion.name for motion in found[1]}
            contents = [digest.of(_content(motion, digest, known)) for motion in found[1]]
            for (motion, content), engine in product(zip(found[1], contents, strict=True), engine_names):
                task = _task(matrix, found[0], motion, content, engine, revision, axes, digest)
                if left_out(matrix.matrix, task):
                    continue
                name = slug(task.cell)
                if name in tasks:
                    raise InputError(
                        f"{matrix.path}: two cells are the same: {task.title} of {file.scenario.name}; expected "
                        "scenarios with different names and axis values that differ"
                    )
                tasks[name] = task
    check_left_out(matrix, recorded)
    if not tasks:
        there = ", ".join(sorted({case.name for file in matrix.scenarios for case in file.cases()}))
        raise InputError(
            f"{matrix.path}: holds no cell; recordings is {', '.join(matrix.matrix.recordings)}; expected patterns "
            f"that match {there or 'a recording'}, and not everything left out"
        )
    return sorted(tasks.values(), key=lambda task: _place(task, matrix))


def _place(task: Task, matrix: MatrixFile) -> tuple[int, str, str, list[int]]:
    """Where a person looks for a cell: the values of every axis in the order of the file, the last axis's fastest."""
    values = [matrix.matrix.axes[axis].index(value) for axis, value in task.axes.items()]
    scenario = [file.path for file in matrix.scenarios].index(task.file.path)
    return scenario, task.engine, task.motion.name, values


def _variants(
    matrix: MatrixFile, file: ScenarioFile, read: Reader
) -> Iterator[tuple[dict[str, Any], str, tuple[ScenarioFile, list[RepeatedMotion]]]]:
    """Every combination of axis values, with the scenario and its motions under it."""
    first: tuple[list[Experiment], list[RepeatedMotion]] | None = None
    names = list(matrix.matrix.axes)
    for values in product(*matrix.matrix.axes.values()):
        axes = dict(zip(names, values, strict=True))
        revision, variant = variant_of(matrix, file, axes)
        others = {k: v for k, v in axes.items() if k not in NAMED_AXES}
        found = [_with_axes(e, others) for e in experiments(variant, read=read, only=matrix.matrix.recordings)]
        if first is None:
            first = found, motions(found)
        yield axes, revision, (variant, regrouped(first, found))


def _with_axes(experiment: Experiment, others: dict[str, Any]) -> Experiment:
    overrides = json.dumps(json.loads(experiment.overrides) | others, sort_keys=True)
    if overrides == experiment.overrides:
        return experiment  # with what it has found out already, as how a body was thrown
    return replace(experiment, overrides=overrides)


def regrouped(first: tuple[list[Experiment], list[RepeatedMotion]], found: list[Experiment]) -> list[RepeatedMotion]:
    """Motions of the same recordings under other axis values; recordings that differ are grouped anew."""
    before, grouped = first
    same = len(before) == len(found) and all(
        a.recording is b.recording and (a.name, a.window, a.use) == (b.name, b.window, b.use)
        for a, b in zip(before, found, strict=True)
    )
    if not same:
        return motions(found)
    place = {id(e): i for i, e in enumerate(before)}
    return [replace(m, experiments=tuple(found[place[id(e)]] for e in m.experiments)) for m in grouped]


def _task(
    matrix: MatrixFile,
    file: ScenarioFile,
    motion: RepeatedMotion,
    content: str,
    engine: str,
    revision: str,
    axes: dict[str, Any],
    d: Digest,
) -> Task:
    m = matrix.matrix
    parts = [content, engine, engines.load(engine).version, revision, m.floors, m.traces, code_version()]
    return Task(d.of(parts)[:32], file, motion, engine, revision, axes, m.floors, m.traces)


def _content(motion: RepeatedMotion, digest: Digest, known: dict[int, tuple[Scenario, str]]) -> list[Any]:
    """What a motion's result depends on: of the scenario, not what concerns other recordings or budgets.

    What was digested of a scenario, which most motions share, is `known` from then on.
    """
    parts: list[Any] = [motion.name, digest.of(motion.measured), list(motion.shifts)]
    parts.append({"/".join(k): v for k, v in motion.noise.items()})
    for e in motion.experiments:
        if id(e.scenario) not in known:  # holding the scenario keeps its id from being given away
            dump = e.scenario.model_dump(exclude={"revisions": True, "budget": True, "recordings": {"runs"}})
            known[id(e.scenario)] = e.scenario, digest.of(dump)
        parts += [e.name, known[id(e.scenario)][1], digest.of(e.plant), digest.of(e.recording), digest.of(e.commands)]
        parts += [e.begin, e.duration, e.use, list(e.window), e.overrides]
    return parts
