"""The same cells on a Dask cluster that exists: every Dask worker thread attends to cells as a local one does."""

import asyncio
import pickle
import tempfile
from collections.abc import Iterator, Sequence
from itertools import islice
from pathlib import Path
from typing import Any

from realitygap.files.errors import InputError
from realitygap.matrix.attend import Workers, attend
from realitygap.matrix.digest import code_version
from realitygap.matrix.local import Done
from realitygap.matrix.task import Task

AHEAD = 4
"""Cells that are handed out per thread of the cluster, so that no thread waits and the scheduler stays small."""
CONNECT = "20s"


def run_cluster(tasks: Sequence[Task], scheduler: str, store: str, limit: float, done: Done) -> None:
    """Compute cells on the cluster of a scheduler. The store must be reachable from its workers.

    Raises:
        InputError: where the scheduler cannot be reached, has no workers or its workers run other code.
    """
    try:
        from distributed import Client, KilledWorker, as_completed
    except ImportError:
        raise InputError("--scheduler: needs distributed; install it with: pip install 'realitygap[cluster]'") from None
    _check_answers(scheduler)
    with Client(scheduler, timeout=CONNECT, set_as_default=False) as client:
        threads = _threads(client, scheduler)
        waiting = iter(tasks)
        futures = {}

        def hand_out(count: int) -> Iterator[Any]:
            for task in islice(waiting, count):
                future = client.submit(work, pickle.dumps(task), store, limit, key=f"cell-{task.key}", pure=False)
                futures[future.key] = task
                yield future

        running = as_completed(hand_out(AHEAD * threads), loop=client.loop, raise_errors=False)
        for future in running:
            task = futures.pop(future.key)
            try:
                done(task, future.result())
            except KilledWorker:
                done(task, "its worker was killed every time")
            running.update(list(hand_out(1)))


def work(pickled: bytes, store: str, limit: float) -> str | None:
    """One cell on a worker of the cluster."""
    return attend(pickle.loads(pickled), pickled, store, limit, _workers)


def _check_answers(scheduler: str) -> None:
    """Make sure that a scheduler is there: a `Client` of one that is not waits twice its timeout to be closed."""
    from dask.utils import parse_timedelta
    from distributed.comm import connect
    from distributed.security import Security

    async def ask() -> None:
        arguments = Security().get_connection_args("client")
        comm = await connect(scheduler, timeout=parse_timedelta(CONNECT), **arguments)
        comm.abort()

    try:
        asyncio.run(ask())
    except (OSError, ValueError) as error:
        raise InputError(f"--scheduler: {scheduler} does not answer ({error}); expected host:port") from None


def _threads(client: Any, scheduler: str) -> int:
    """How many threads the cluster has, once its workers are known to run this code."""
    try:
        client.wait_for_workers(1, timeout=20)
    except TimeoutError:
        raise InputError(f"--scheduler: {scheduler} has no workers; expected at least one") from None
    for address, version in client.run(code_version).items():
        if version != code_version():
            raise InputError(f"--scheduler: worker {address} runs another version of realitygap or its packages")
    return sum(client.nthreads().values())


_workers = Workers(Path(tempfile.gettempdir()))
"""Those of a worker of the cluster, which end when it does."""
