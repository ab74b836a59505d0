"""Getting one cell done, whatever happens to the process that does it."""

import pickle
import threading
from pathlib import Path

from realitygap.matrix.store import open_store
from realitygap.matrix.task import Task, compute, lost
from realitygap.matrix.worker import Died, Hung, Worker

TRIES = 2
"""A cell whose process was killed from outside is tried once more."""


class Closed(Exception):
    """The work is over: no process is started any more."""


class Workers:
    """The processes that compute cells: one for each thread that asks. `temporary` is their folder for such files."""

    def __init__(self, temporary: Path) -> None:
        self._temporary = temporary
        self._own = threading.local()
        self._all: set[Worker] = set()
        self._ready: list[Worker] = []
        self._closed = False
        self._lock = threading.Lock()

    def begin(self, number: int) -> None:
        """Start so many processes for threads that are yet to ask: they load their packages meanwhile."""
        with self._lock:
            self._ready += [Worker(self._temporary) for _ in range(number)]
            self._all.update(self._ready)

    def own(self) -> Worker:
        """The process of this thread, started where there is none.

        Raises:
            Closed: after `close`.
        """
        worker: Worker | None = getattr(self._own, "worker", None)
        with self._lock:
            if self._closed:
                raise Closed
            if worker is None or not worker.alive:
                worker = self._own.worker = self._ready.pop() if self._ready else Worker(self._temporary)
                self._all.add(worker)
        return worker

    def close(self) -> None:
        """End all processes, from any thread: whoever waits for one gets `Closed`."""
        with self._lock:
            self._closed = True
            for worker in self._all:
                worker.kill()


def kept(pickled: bytes, store: str) -> None:
    """Compute a cell here, and keep its file in the store."""
    task: Task = pickle.loads(pickled)
    data = compute(task)
    open_store(store).write(task.key, data)


def attend(task: Task, pickled: bytes, store: str, limit: float, workers: Workers) -> str | None:
    """Compute a cell in the process that belongs to this thread. Afterwards its file is in the store.

    Returns:
        None; or what happened, in words, where the process was killed every time: the cell then stays to be done.

    Raises:
        Closed: where the work ended before the cell did.
    """
    what = ""
    for _ in range(TRIES):
        try:
            workers.own().run(kept, pickled, store, limit=limit)
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
