"""Processes of a pool do not outlive the work that they were started for."""

import multiprocessing
import time
from concurrent.futures import ProcessPoolExecutor

import pytest
from realitygap.files.interrupted import Interrupted
from realitygap.files.lifeline import ended_with_it

LONG = 120.0
"""s that every piece of work takes."""


@pytest.mark.parametrize("end", [Interrupted(15), ValueError("no good")])
def test_a_pool_ends_with_the_work_that_is_interrupted(end: BaseException) -> None:
    before = set(multiprocessing.active_children())
    began = time.monotonic()
    with pytest.raises(type(end)):
        _work(end)
    assert time.monotonic() - began < LONG / 2
    assert set(multiprocessing.active_children()) == before


def _work(end: BaseException) -> None:
    """More than the pool can do at once, and an end in the middle of it."""
    with ProcessPoolExecutor(2, multiprocessing.get_context("fork")) as pool, ended_with_it(pool):
        for _ in range(4):
            pool.submit(time.sleep, LONG)
        raise end
