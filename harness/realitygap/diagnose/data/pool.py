"""Worker processes that share one problem: they are forked from it, so that nothing is sent but the questions."""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from typing import Any, TypeVar

from realitygap.diagnose.data.problem import Problem

Answer = TypeVar("Answer")
_problem: Problem | None = None


class Pool:
    """Runs functions of a problem in worker processes. A changed problem needs a new pool: `renew`."""

    def __init__(self, problem: Problem, workers: int | None = None) -> None:
        self.problem = problem
        self.workers = workers or len(os.sched_getaffinity(0))
        self._executor: ProcessPoolExecutor | None = None

    def map(self, function: Callable[..., Answer], questions: Sequence[tuple[Any, ...]]) -> list[Answer]:
        """function(problem, *question) for every question, in their order."""
        if self.workers == 1 or len(questions) <= 1:
            return [function(self.problem, *q) for q in questions]
        if self._executor is None:
            global _problem
            _problem = self.problem
            self._executor = ProcessPoolExecutor(self.workers, mp_context=multiprocessing.get_context("fork"))
        futures = [self._executor.submit(_ask, function, q) for q in questions]
        return [f.result() for f in futures]

    def renew(self) -> None:
        """Fork anew, after the problem was changed."""
        self.close()

    def close(self) -> None:
        """End the workers."""
        if self._executor is not None:
            self._executor.shutdown(cancel_futures=True)
            self._executor = None

    def __enter__(self) -> Pool:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def _ask(function: Callable[..., Answer], question: tuple[Any, ...]) -> Answer:
    assert _problem is not None
    return function(_problem, *question)
