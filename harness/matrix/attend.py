"""Getting one cell done, whatever happens to the process that does it."""

import threading

from harness.matrix.store import open_store
from harness.matrix.task import Task, lost
from harness.matrix.worker import Died, Hung, Worker

TRIES = 2
"""A cell whose process was killed from outside is tried once more."""
_own = threading.local()


def attend(task: Task, pickled: bytes, store: str, limit: float) -> str | None:
    """Compute a cell in the process that belongs to this thread. Afterwards its file is in the store.

    Returns:
        None; or what happened, in words, where the process was killed every time: the cell then stays to be done.
    """
    what = ""
    for _ in range(TRIES):
        try:
            own_worker().run(pickled, store, limit)
            return None
        except Hung:
            data = lost(task, "timeout", f"took longer than the time limit of {limit:g} s")
        except Died as end:
            what = str(end)
            if end.killed:
                continue
            data = lost(task, "crashed", what)
        open_store(store).write(task.key, data)
        return None
    return what


def own_worker() -> Worker:
    """The process of this thread, started where there is none."""
    worker: Worker | None = getattr(_own, "worker", None)
    if worker is None or not worker.alive:
        worker = _own.worker = Worker()
        _all.add(worker)
    return worker


def close_workers() -> None:
    """End the processes of all threads."""
    while _all:
        _all.pop().close()


_all: set[Worker] = set()
