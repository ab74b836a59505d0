"""Simulations of a problem, in worker processes; what was simulated once is remembered."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from queue import SimpleQueue
from typing import cast

from realitygap.diagnose.data.changes import Change
from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.data.worker import Query, answer
from realitygap.robot.drive import Array
from realitygap.simulate.opened import kept_open

KEPT = 256e6
"""Bytes of signals that are remembered."""


class Simulations:
    """Simulates the cases of a problem with changes, in `workers` processes that load the engines themselves."""

    def __init__(self, problem: Problem, workers: int | None = None) -> None:
        self.problem = problem
        self.count = 0
        self._remembered: dict[Query, dict[str, Array] | None] = {}
        self._bytes = 0.0
        self.workers = workers or len(os.sched_getaffinity(0))
        self._workers = [_Worker(problem) for _ in range(self.workers)] if self.workers > 1 else []
        self._idle: SimpleQueue[_Worker] = SimpleQueue()
        for worker in self._workers:
            self._idle.put(worker)
        self._threads = ThreadPoolExecutor(len(self._workers)) if self._workers else None
        self._ends = ExitStack()

    def ask(self, queries: Sequence[Query]) -> list[dict[str, Array] | None]:
        """The signals of every query, in their order; None for a simulation that failed."""
        new = [q for q in dict.fromkeys(queries) if q not in self._remembered]
        self.count += len(new)
        if self._threads is None or len(new) == 1:
            fresh = dict(zip(new, [answer(self.problem, q) for q in new], strict=True))
        else:
            fresh = dict(zip(new, self._threads.map(self._send, new), strict=True))
        out = [fresh[q] if q in fresh else self._remembered[q] for q in queries]
        for q, signals in fresh.items():
            self._remember(q, signals)
        return out

    def of(
        self,
        changes: Sequence[Change],
        cases: Sequence[int],
        *,
        engine: str | None = None,
        coarse: Coarse | None = None,
    ) -> list[dict[str, Array] | None]:
        """The signals of some cases with changes, at the least faithful step rate where `coarse` says which that is."""
        return self.ask([self.query(changes, c, engine=engine, coarse=coarse) for c in cases])

    def query(
        self, changes: Sequence[Change], case: int, *, engine: str | None = None, coarse: Coarse | None = None
    ) -> Query:
        """The query of one case."""
        finer = 1.0 if coarse is None else coarse[case]
        return Query(tuple(changes), case, engine or self.problem.engine, finer)

    def _remember(self, query: Query, signals: dict[str, Array] | None) -> None:
        size = sum(v.nbytes for v in signals.values()) if signals else 0
        while self._remembered and self._bytes + size > KEPT:
            oldest = next(iter(self._remembered))
            gone = self._remembered.pop(oldest)
            self._bytes -= sum(v.nbytes for v in gone.values()) if gone else 0
        self._remembered[query] = signals
        self._bytes += size

    def _send(self, query: Query) -> dict[str, Array] | None:
        worker = self._idle.get()
        try:
            return worker.ask(query)
        finally:
            self._idle.put(worker)

    def close(self) -> None:
        """End the workers."""
        if self._threads is not None:
            self._threads.shutdown(cancel_futures=True)
        for worker in self._workers:
            worker.close()
        self._ends.close()

    def __enter__(self) -> Simulations:
        self._ends.enter_context(kept_open())
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


Coarse = Sequence[float]
"""The least share of the step rate that is faithful, by case."""


class _Worker:
    """One process; it starts with the first query."""

    def __init__(self, problem: Problem) -> None:
        self._problem = problem
        self._process: subprocess.Popen[bytes] | None = None

    def ask(self, query: Query) -> dict[str, Array] | None:
        if self._process is None:
            environment = os.environ | {"PYTHONPATH": os.pathsep.join(p for p in sys.path if p)}
            self._process = subprocess.Popen(
                [sys.executable, "-m", "realitygap.diagnose.data.worker"],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                env=environment,
            )
            self._write(self._problem)
        self._write(query)
        assert self._process.stdout is not None
        try:
            good, result = pickle.load(self._process.stdout)
        except (
            EOFError,
            pickle.UnpicklingError,
        ):  # an engine that takes its process down cannot simulate this; the next query has a new one
            self.close()
            self._process = None
            return None
        if not good:
            raise RuntimeError(result)
        return cast("dict[str, Array] | None", result)

    def _write(self, message: object) -> None:
        assert self._process is not None
        assert self._process.stdin is not None
        pickle.dump(message, self._process.stdin, pickle.HIGHEST_PROTOCOL)
        self._process.stdin.flush()

    def close(self) -> None:
        if self._process is not None:
            for stream in (self._process.stdin, self._process.stdout):
                if stream is not None:
                    stream.close()
            self._process.wait()
