"""Simulations of a problem, in worker processes; what was simulated once is remembered."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from queue import SimpleQueue
from threading import Lock
from typing import TypeVar, cast

from realitygap.diagnose.data.changes import Change
from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.data.processes import Died, Process, number
from realitygap.diagnose.data.worker import Query, Question
from realitygap.robot.drive import Array
from realitygap.simulate.opened import kept_open

Item = TypeVar("Item")
Done = TypeVar("Done")

KEPT = 256e6
"""Bytes of signals that are remembered."""
WAITING = 2
"""Works that wait for a worker: with none an SO-101 took 168 s, and workers stood still for a sixth of that."""


class Simulations:
    """Simulates the cases of a problem with changes, in `workers` processes that load the engines themselves.

    Processes that were started `ahead` are taken from their list first.

    Attributes:
        count: simulations that were made.
        steps: of engines that were asked for, also of what was remembered: what is looked for after so many does not
            hang on how fast a processor is, or what else it does.
    """

    def __init__(self, problem: Problem, workers: int | None = None, ahead: list[Process] | None = None) -> None:
        self.problem = problem
        self.count = 0
        self.steps = 0.0
        self._length = [sum(e.duration * e.scenario.physics.step_rate for e in c.pieces) for c in problem.cases]
        self._remembered: dict[Query, dict[str, Array] | None] = {}
        self._bytes = 0.0
        self.workers = number(workers)
        self._workers = [_Worker(problem, ahead or []) for _ in range(self.workers)] if self.workers > 1 else []
        self._idle: SimpleQueue[_Worker] = SimpleQueue()
        for worker in self._workers:
            self._idle.put(worker)
        self._threads = ThreadPoolExecutor(len(self._workers)) if self._workers else None
        self._own, self._memory = Lock(), Lock()
        self._ends = ExitStack()

    def ask(self, queries: Sequence[Query]) -> list[dict[str, Array] | None]:
        """The signals of every query, in their order; None for a simulation that failed."""
        with self._memory:  # what is remembered now may make room for what others ask meanwhile
            known = {q: self._remembered[q] for q in queries if q in self._remembered}
            new = [q for q in dict.fromkeys(queries) if q not in known]
            self.count += len(new)
            self.steps += sum(self._length[q.case] * q.finer for q in set(queries))
        fresh = dict(zip(new, self._answers(new), strict=True))
        with self._memory:
            for q, signals in fresh.items():
                self._remember(q, signals)
        known |= fresh
        return [known[q] for q in queries]

    def _answers(self, new: Sequence[Query]) -> list[dict[str, Array] | None]:
        """Simulated: one alone in this process, if nobody else does that meanwhile, several by the workers."""
        if len(new) == 1 and self._own.acquire(blocking=False):
            try:
                return [new[0].answer(self.problem)]
            finally:
                self._own.release()
        return self.each(new)

    def each(self, questions: Sequence[Question[Done]]) -> list[Done | None]:
        """The answers to any questions, in their order, by the workers; None where one took its process down."""
        if self._threads is None:
            return [q.answer(self.problem) for q in questions]
        return list(self._threads.map(self._send, questions))

    def side_by_side(self, work: Callable[[Item], Done], items: Sequence[Item]) -> list[Done]:
        """What some work makes of every item, in their order: of some more at once than there are workers, so that
        these have something to simulate while this process works.
        """
        if self.workers < 2 or len(items) < 2:
            return [work(item) for item in items]
        threads = ThreadPoolExecutor(self.workers + WAITING)
        try:
            return list(threads.map(work, items))
        except BaseException:  # the others need not wait for their simulations to end
            self.close()
            raise
        finally:
            threads.shutdown(cancel_futures=True)

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
        if query in self._remembered:  # two asked at once
            return
        size = sum(v.nbytes for v in signals.values()) if signals else 0
        while self._remembered and self._bytes + size > KEPT:
            oldest = next(iter(self._remembered))
            gone = self._remembered.pop(oldest)
            self._bytes -= sum(v.nbytes for v in gone.values()) if gone else 0
        self._remembered[query] = signals
        self._bytes += size

    def _send(self, question: Question[Done]) -> Done | None:
        worker = self._idle.get()
        try:
            return worker.ask(question)
        finally:
            self._idle.put(worker)

    def close(self) -> None:
        """End the workers at once: whoever still waits for one has no answer."""
        if self._threads is not None:
            self._threads.shutdown(wait=False, cancel_futures=True)
            for worker in self._workers:
                worker.kill()
            self._threads.shutdown()
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
    """A process that knows the problem; it starts with the first question, where none was started ahead."""

    def __init__(self, problem: Problem, ahead: list[Process]) -> None:
        self._problem, self._ahead = problem, ahead
        self._process: Process | None = None

    def ask(self, question: Question[Done]) -> Done | None:
        try:
            if self._process is None:
                self._process = self._ahead.pop() if self._ahead else Process()
                self._process.tell(self._problem)
            self._process.tell(question)
            good, result = cast("tuple[bool, object]", self._process.answer())
        except Died:  # an engine that takes its process down cannot simulate this; the next question has a new one
            self.close()
            return None
        if not good:
            raise RuntimeError(result)
        return cast("Done", result)

    def kill(self) -> None:
        if self._process is not None:
            self._process.kill()

    def close(self) -> None:
        if self._process is not None:
            self._process.close()
        self._process = None
