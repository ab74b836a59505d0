"""Processes that simulate, and the handle that who asks them holds. Nothing heavy is imported here: they can be started
before the command that needs them has loaded its own packages, and load theirs meanwhile.
"""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress

from realitygap.files.threads import THREADS


class Died(Exception):
    """The process ended at its work."""


class Process:
    """One process, started at once."""

    def __init__(self) -> None:
        self._process = subprocess.Popen(
            [sys.executable, "-m", "realitygap.diagnose.data.worker"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env=os.environ | {"PYTHONPATH": os.pathsep.join(p for p in sys.path if p)},
            process_group=0,  # Ctrl-C is for who started it to handle
        )

    def tell(self, message: object) -> None:
        """Send a message.

        Raises:
            Died: where the process has ended.
        """
        assert self._process.stdin is not None
        try:
            pickle.dump(message, self._process.stdin, pickle.HIGHEST_PROTOCOL)
            self._process.stdin.flush()
        except BrokenPipeError:
            raise Died from None

    def answer(self) -> object:
        """Wait for the next message.

        Raises:
            Died: where the process has ended.
        """
        assert self._process.stdout is not None
        try:
            return pickle.load(self._process.stdout)
        except (EOFError, pickle.UnpicklingError):
            raise Died from None

    def kill(self) -> None:
        """End it at once, from any thread: whoever waits for an answer finds it ended."""
        self._process.kill()

    def close(self) -> None:
        """End it."""
        self.kill()  # it writes nothing
        for stream in (self._process.stdin, self._process.stdout):
            if stream is not None:
                with suppress(BrokenPipeError):  # a question that it did not read
                    stream.close()
        self._process.wait()


def number(jobs: int | None) -> int:
    """How many processes there are for so many jobs; None: as many as cores."""
    return jobs or len(os.sched_getaffinity(0))


@contextmanager
def started(jobs: int | None) -> Iterator[list[Process]]:
    """As many processes as there are jobs (None: cores), none where one does all; those that are still in the list at
    the end are ended. Who uses one takes it out.

    They share the cores with this one: linear algebra that is loaded from here on takes one thread each, unless the
    environment says otherwise, which also makes its rounding the same on every machine.
    """
    count = number(jobs)
    for name in THREADS:
        os.environ.setdefault(name, "1")
    found = [Process() for _ in range(count if count > 1 else 0)]
    try:
        yield found
    finally:
        for process in found:
            process.close()
