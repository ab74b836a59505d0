"""`realitygap matrix`: all cells of a matrix, resumable, and the result folder made from them."""

from dataclasses import dataclass
from pathlib import Path

from realitygap.files.progress import Progress
from realitygap.files.result_folder import written_whole
from realitygap.matrix.cluster import run_cluster
from realitygap.matrix.collect import Collected, collect
from realitygap.matrix.estimate import Estimate
from realitygap.matrix.local import run_local
from realitygap.matrix.matrix_file import load_matrix
from realitygap.matrix.plan import plan
from realitygap.matrix.store import Store, open_store
from realitygap.matrix.task import Outcome, Task, read_outcome
from realitygap.report import write_figures, write_page

RETRIED = ("crashed", "timeout")
"""Outcomes that stay until it is asked for them again."""


@dataclass(frozen=True)
class Settings:
    """How a matrix is run.

    Attributes:
        jobs: processes on this machine.
        scheduler: address of a Dask scheduler; None computes here.
        store: path or URL where finished cells are kept; None keeps them in `cells` of the result folder.
        retry_crashed: whether cells that crashed or took too long are tried again.
    """

    jobs: int = 1
    scheduler: str | None = None
    store: str | None = None
    retry_crashed: bool = False

    def place(self, out: Path) -> str:
        """Where the cells are kept."""
        return self.store or str((out / "cells").absolute())


def run_matrix(path: Path, out: Path, settings: Settings, progress: Progress) -> tuple[Collected, Path]:
    """Compute the cells that are not there yet and make the result folder. Returns it and its page.

    Raises:
        InputError: for a matrix that cannot be run; nothing is written then.
    """
    matrix = load_matrix(path)
    progress.say(f"reading {path}")
    tasks = plan(matrix)
    place = settings.place(out)
    store = open_store(place)
    there = finished(tasks, store, retry_crashed=settings.retry_crashed)
    estimate = Estimate(there.values())
    todo = sorted((t for t in tasks if t.key not in there), key=estimate.seconds, reverse=True)
    undone: dict[str, str] = {}
    with progress.task("simulating", len(todo)) as advance:

        def done(task: Task, what: str | None) -> None:
            advance(task.title)
            if what is not None:
                undone[task.key] = what

        if todo and settings.scheduler:
            run_cluster(todo, settings.scheduler, place, matrix.matrix.time_limit, done)
        elif todo:
            run_local(todo, min(settings.jobs, len(todo)), place, matrix.matrix.time_limit, done)
    with written_whole(out) as folder:
        collected = collect(matrix, tasks, undone, store, folder)
        if matrix.matrix.traces:
            write_figures(folder)
        page = out / write_page(folder).name
    return collected, page


def finished(tasks: list[Task], store: Store, *, retry_crashed: bool = False) -> dict[str, Outcome]:
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


def dry_run(path: Path, out: Path, settings: Settings) -> list[str]:
    """Lines that list the cells, which of them are there, and how long the others will take."""
    tasks = plan(load_matrix(path))
    there = finished(tasks, open_store(settings.place(out)), retry_crashed=settings.retry_crashed)
    estimate = Estimate(there.values())
    lines = []
    for task in tasks:
        state = "there" if task.key in there else f"{estimate.seconds(task):.1f} s"
        lines.append(f"{task.file.scenario.name:18} {task.title:60} {state}")
    todo = [t for t in tasks if t.key not in there]
    total = estimate.total(todo, settings.jobs)
    lines.append(
        f"{len(tasks)} cells, {len(there)} of them there; the others and the report take about {total:.0f} s with "
        f"{settings.jobs} process{'es' if settings.jobs != 1 else ''} where the machine has nothing else to do"
    )
    return lines
