"""Cells on this machine: as many threads as asked for, each with a process of its own."""

import pickle
import tempfile
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path

from realitygap.files.unfinished import ELSEWHERE, part_folder
from realitygap.matrix.attend import Workers, attend
from realitygap.matrix.task import Task

Done = Callable[[Task, str | None], None]
"""Told of every cell that is done, and what happened where it is not."""


def run_local(
    tasks: Sequence[Task],
    jobs: int,
    store: str,
    limit: float,
    done: Done,
    pickled: Callable[[Task], bytes] = pickle.dumps,
) -> None:
    """Compute cells with `jobs` processes. Interrupted, it ends them at once; the cells that are done are kept."""

    def work(task: Task) -> str | None:
        return attend(task, pickled(task), store, limit, workers)

    with part_folder(Path(tempfile.gettempdir()), ELSEWHERE) as temporary:  # goes, also where processes were ended
        workers, pool = Workers(temporary), ThreadPoolExecutor(jobs)
        try:
            futures = {pool.submit(work, task): task for task in tasks}
            for future in as_completed(futures):
                done(futures[future], future.result())
        finally:
            pool.shutdown(wait=False, cancel_futures=True)
            workers.close()
            pool.shutdown()
