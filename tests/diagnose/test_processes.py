"""Processes that simulate are the same whether they were started ahead or not, and end with what they are for."""

import os
import subprocess
import sys
import time

import numpy as np
import pytest
from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.data.processes import Died, Process, started
from realitygap.diagnose.data.simulations import Simulations
from realitygap.files.threads import THREADS
from realitygap.robot.drive import Array


def alive(process: Process) -> bool:
    return process._process.poll() is None


def test_processes_started_ahead_answer_as_this_one_does(problem: Problem) -> None:
    cases = range(len(problem.cases))
    with Simulations(problem, 1) as own:
        expected = own.of([], cases)
    with started(2) as ahead:
        both = list(ahead)
        with Simulations(problem, 2, ahead) as simulations:
            found = simulations.of([], cases)
            assert not ahead, "others were started"
            assert all(map(alive, both))
        assert not any(map(alive, both))
    for a, b in zip(expected, found, strict=True):
        assert a is not None
        assert b is not None
        assert a.keys() == b.keys()
        assert all(np.array_equal(a[s], b[s]) for s in a)


def test_what_one_asks_again_is_there_whatever_others_ask_meanwhile(
    problem: Problem, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With no room to remember more than one motion, each that is simulated takes the place of one that another may be
    about to read."""
    monkeypatch.setitem(Simulations._remember.__globals__, "KEPT", 0.0)
    cases = range(len(problem.cases))
    with Simulations(problem, 2) as simulations:
        expected = simulations.of([], cases)

        def both(finer: float) -> list[bool]:
            """Whether a motion that was just asked for comes out the same beside new ones."""
            case = int(10.0 * finer) % len(cases)
            first = simulations.ask([simulations.query([], case)])
            new = [simulations.query([], c, coarse=[finer] * len(cases)) for c in cases]
            again = simulations.ask([simulations.query([], case), *new])
            return [_same(found, expected[case]) for found in (first[0], again[0])]

        assert all(map(all, simulations.side_by_side(both, [0.5, 0.6, 0.7, 0.8, 0.9])))


def _same(a: dict[str, Array] | None, b: dict[str, Array] | None) -> bool:
    return a is not None and b is not None and all(np.array_equal(a[s], b[s]) for s in b)


def test_who_needs_none_ends_them_at_once() -> None:
    with pytest.raises(ValueError, match="bad input"), started(2) as ahead:  # noqa: PT012 (it is about the end)
        both, began = list(ahead), time.monotonic()
        raise ValueError("bad input")
    assert len(both) == 2
    assert not any(map(alive, both))
    assert time.monotonic() - began < 1.0, "they were waited for until they had loaded everything"


def test_none_are_started_where_one_process_does_all() -> None:
    with started(1) as ahead:
        assert ahead == []


@pytest.mark.parametrize("said", [None, "2"])
def test_they_share_the_cores(monkeypatch: pytest.MonkeyPatch, said: str | None) -> None:
    """Linear algebra takes one thread in each, unless whoever runs it has said otherwise."""
    for name in THREADS:
        if said is None:
            monkeypatch.delenv(name, raising=False)
        else:
            monkeypatch.setenv(name, said)
    with started(1):
        assert [os.environ[name] for name in THREADS] == [said or "1"] * len(THREADS)


def test_one_that_has_ended_says_so() -> None:
    process = Process()
    process.kill()
    with pytest.raises(Died):
        process.answer()
    process.close()


def test_starting_them_takes_no_package() -> None:
    """They are started before the command has loaded its own: loading what starts them has to be quick."""
    heavy = ("numpy", "scipy", "pandas", "numba", "mujoco", "matplotlib")
    code = f"import sys, realitygap.diagnose.data.processes; print([m for m in {heavy} if m in sys.modules])"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, check=True).stdout == b"[]\n"
