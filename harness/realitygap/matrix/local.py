"""Work on this machine: as many threads as asked for, each with a process of its own."""

import pickle
import tempfile
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TypeVar

from realitygap.files.unfinished import ELSEWHERE, part_folder
from realitygap.matrix.attend import Workers, attend
from realitygap.matrix.task import Task
from realitygap.matrix.worker import Died, Hung

Done = Callable[[Task, str | None], None]
"""Told of every cell that is done, and what happened where it is not."""
Item = TypeVar("Item")
Result = TypeVar("Result")
LONG = 600.0
"""s in which a piece of work that is no cell has to be done; what takes longer is done anew by this process."""


class Local:
    """Processes of this machine, which start with the first work, or before it, and stay until `close`.

    Args:
        jobs: how many.
        temporary: their folder for temporary files.
    """

    def __init__(self, jobs: int, temporary: Path) -> None:
        self.jobs = jobs
        self._workers, self._pool = Workers(temporary), ThreadPoolExecutor(jobs)

    def begin(self, number: int) -> None:
        """Start so many of the processes now: they load their packages while the work is being planned."""
        self._workers.begin(min(number, self.jobs))

    def cells(
        self,
        tasks: Sequence[Task],
        store: str,
        limit: float,
        done: Done,
        pickled: Callable[[Task], bytes] = pickle.dumps,
    ) -> None:
        """Compute cells, each within `limit` [s]. Those that are done are kept where it is interrupted."""

        def work(task: Task) -> str | None:
            return attend(task, pickled(task), store, limit, self._workers)

        futures = {self._pool.submit(work, task): task for task in tasks}
        for future in as_completed(futures):
            done(futures[future], future.result())

    def each(self, work: Callable[[Item], Result], items: Sequence[Item]) -> list[Result]:
        """What a function of a module makes of every item, in their order; one process is this one.

        What fails in a process, whatever it is, is done again by this one, which raises what it raises.
        """

        def there(item: Item) -> list[Result]:
            with suppress(Died, Hung):
                return [self._workers.own().run(work, item, limit=LONG)]
            return []

        if self.jobs == 1:
            return [work(item) for item in items]
        found = self._pool.map(there, items)
        return [one[0] if one else work(item) for item, one in zip(items, found, strict=True)]

    def close(self) -> None:
        """End the processes at once."""
        self._pool.shutdown(wait=False, cancel_futures=True)
        self._workers.close()
        self._pool.shutdown()


@contextmanager
def local(jobs: int) -> Iterator[Local]:
    """So many processes, for as long as there is work."""
    with part_folder(Path(tempfile.gettempdir()), ELSEWHERE) as temporary:  # goes, also where processes were ended
        here = Local(jobs, temporary)
        try:
            yield here
        finally:
            here.close()
