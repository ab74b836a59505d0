"""Processes that end when the work of the one that started them is over, however it ended."""

import multiprocessing
import os
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager

LOOK = 0.5
"""s between looks."""


def end_with(parent: int) -> None:
    """End this process, whatever it is at, soon after its parent of that number has ended."""

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(LOOK)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


@contextmanager
def ended_with_it(pool: ProcessPoolExecutor) -> Iterator[None]:
    """Where the work inside fails or is interrupted, the processes of its pool end at once: a pool waits for all that
    was handed to it otherwise.
    """
    others = set(multiprocessing.active_children())
    try:
        yield
    except BaseException:
        own = set(multiprocessing.active_children()) - others
        for process in own:
            process.kill()
        pool.shutdown(wait=True, cancel_futures=True)
        for process in own:
            process.join()
        raise
