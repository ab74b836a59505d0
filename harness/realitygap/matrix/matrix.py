"""The cells of a matrix planned, computed where it was asked for, and collected; `run` is a matrix of one scenario."""

import os
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from realitygap.files.found import counted
from realitygap.files.progress import Progress
from realitygap.files.result_folder import written_whole
from realitygap.files.whole import made
from realitygap.matrix.aside import Aside, laid_aside
from realitygap.matrix.checked import checked
from realitygap.matrix.cluster import run_cluster
from realitygap.matrix.collect import Collected, collect
from realitygap.matrix.estimate import StepCost, costs
from realitygap.matrix.local import Local, local
from realitygap.matrix.matrix_file import MatrixFile
from realitygap.matrix.plan import Reader, plan
from realitygap.matrix.store import Store, open_store
from realitygap.matrix.task import Outcome, Task, read_outcome
from realitygap.recording.lack import noticed

RETRIED = ("crashed", "timeout")
"""Outcomes that stay until it is asked for them again."""


@dataclass(frozen=True)
class Settings:
    """How a matrix is run.

    Attributes:
        jobs: processes on this machine: what an engine does to its process is one cell's outcome.
        scheduler: address of a Dask scheduler; None computes here.
        store: path or URL where finished cells are kept; None keeps them in `cells` of the result folder.
        keep: whether finished cells are kept for the next time.
        retry_crashed: whether cells that crashed or took too long are tried again.
    """

    jobs: int = 1
    scheduler: str | None = None
    store: str | None = None
    keep: bool = True
    retry_crashed: bool = False

    def place(self, out: Path) -> str:
        """Where the cells are kept."""
        return self.store or str((out / "cells").absolute())


ONCE = Settings(keep=False)
"""How `run` does it: computed anew every time."""


@contextmanager
def results(
    matrix: MatrixFile, out: Path, settings: Settings, progress: Progress
) -> Iterator[tuple[Collected, Path, Local]]:
    """Compute the cells that are not there yet and make the result folder.

    Yields what was found; the folder, which is still aside and takes further files: a page, figures; and the processes
    that have computed cells, for more work. At the end of the `with` block all of it takes the place of `out`, whole.

    Raises:
        InputError: for a matrix that cannot be run; nothing is written then.
    """
    with ExitStack() as stack:
        here = stack.enter_context(local(settings.jobs))
        if settings.scheduler is None:
            here.begin(len(matrix.scenarios) * len(matrix.engine_names()))  # there is at least a cell of each
        warnings, tasks = _planned(matrix, progress)
        _say_notes(tasks, progress)
        stack.enter_context(made(out))
        aside = stack.enter_context(laid_aside(tasks, out))
        tasks = aside.tasks
        stack.callback(here.close)  # before the folders go that they read and write to
        if settings.keep:
            place = settings.place(out)
            undone = work(aside, here, place, settings, matrix.matrix.time_limit, progress)
            folder = stack.enter_context(written_whole(out))
        else:
            folder = stack.enter_context(written_whole(out))
            place = stack.enter_context(TemporaryDirectory(prefix="cells-", dir=folder))
            stack.callback(here.close)  # before the folder goes that they write to
            undone = work(aside, here, place, settings, matrix.matrix.time_limit, progress)
        yield collect(matrix, tasks, undone, open_store(place), folder, warnings), folder, here


def _planned(matrix: MatrixFile, progress: Progress) -> tuple[list[str], list[Task]]:
    """Sentences on likely mistakes, and the cells; recordings are read once, and held by the cells alone."""
    read = Reader()
    return checked(matrix, progress.say, read), plan(matrix, read)


def work(aside: Aside, here: Local, place: str, settings: Settings, limit: float, progress: Progress) -> dict[str, str]:
    """Compute the cells whose files are not in the store at `place`, each within `limit` [s].

    Returns:
        What happened, by key, to the cells that could not be computed.
    """
    tasks = aside.tasks
    store = open_store(place)
    there = finished(tasks, store, retry_crashed=settings.retry_crashed)
    todo = [t for t in tasks if t.key not in there]
    undone: dict[str, str] = {}
    estimate, jobs = StepCost(there.values()), min(settings.jobs, max(len(todo), 1))
    installed = float(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    for line in costs(estimate.total(todo, jobs), todo, jobs, installed):
        progress.say(line)
    with progress.task("simulating", len(todo)) as advance:

        def done(task: Task, what: str | None) -> None:
            advance(task.title)
            if what is not None:
                undone[task.key] = what

        todo.sort(key=estimate.seconds, reverse=True)  # the longest first, so that none is left alone
        if todo and settings.scheduler:
            run_cluster(todo, settings.scheduler, place, limit, done)
        elif todo:
            here.cells(todo, place, limit, done, aside.pickled)
    return undone


def finished(tasks: Sequence[Task], store: Store, *, retry_crashed: bool = False) -> dict[str, Outcome]:
    """The cells whose files are there. A broken file counts as absent."""
    there = store.keys()
    out = {}
    for task in tasks:
        if task.key in there:
            try:
                outcome = read_outcome(store.read(task.key))
            except ValueError:
                continue
            if not (retry_crashed and outcome.outcome in RETRIED):
                out[task.key] = outcome
    return out


def dry_run(matrix: MatrixFile, out: Path, settings: Settings) -> list[str]:
    """Lines that list the cells, which of them are there, and how long the others will take."""
    tasks = plan(matrix)
    there = finished(tasks, open_store(settings.place(out)), retry_crashed=settings.retry_crashed)
    estimate = StepCost(there.values())
    lines = []
    for task in tasks:
        state = "there" if task.key in there else f"{estimate.seconds(task):.1f} s"
        lines.append(f"{task.file.scenario.name:18} {task.title:60} {state}")
    todo, jobs = [t for t in tasks if t.key not in there], settings.jobs
    total = estimate.total(todo, jobs)
    lines.append(
        f"{counted(len(tasks), 'cell')}, {len(there)} of them there; the others and the report take about {total:.0f} "
        f"s with {jobs} process{'es' if jobs != 1 else ''} where the machine has nothing else to do"
    )
    return lines


def _say_notes(tasks: Sequence[Task], progress: Progress) -> None:
    """What was changed in the model, and what is not as it should be in recordings, before the long work begins."""
    found = {(str(t.file.path), e.name): e for t in tasks for e in t.motion.experiments}.values()
    for note in dict.fromkeys(note for e in found for note in e.notes):
        progress.say(note)
    garbled = sum(len(e.recording.outliers) for e in found if e.recording is not None)
    if garbled:
        progress.say(f"readings that jump far away and back, and are not taken: {garbled} (listed in manifest.json)")
    lacking = {e.name: e.recording.absent for e in found if e.recording is not None and e.recording.absent}
    for line in noticed((name, lack) for name, absent in lacking.items() for lack in absent):
        progress.say(line)
    absent_in = sum(any(lack.of_readings for lack in absent) for absent in lacking.values())
    if absent_in:
        progress.say(f"recordings in which readings are absent: {absent_in} (listed in manifest.json)")
