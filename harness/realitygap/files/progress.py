"""Progress of long work: a bar on a terminal, plain lines elsewhere."""

import errno
import os
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeElapsedColumn
from rich.progress import Progress as Bar

EVERY = 5.0
"""Seconds between plain lines."""


class _Terminal(Console):
    """One whose reader may leave: an error as of any other stream, where rich has the status of a failed check."""

    def on_broken_pipe(self) -> None:
        raise BrokenPipeError(errno.EPIPE, os.strerror(errno.EPIPE))


class Progress:
    """Tells a person on standard error how far the work is; `quiet` says nothing."""

    def __init__(self, *, quiet: bool = False) -> None:
        self.quiet = quiet
        self.console = _Terminal(stderr=True)

    @contextmanager
    def task(self, what: str, total: int) -> Iterator[Callable[[str], None]]:
        """A piece of work of `total` steps; call the result with a text at the start of each."""
        if self.quiet:
            yield lambda _: None
        elif self.console.is_terminal:
            columns = (
                TextColumn("{task.description}", markup=False),
                BarColumn(),
                MofNCompleteColumn(),
                TimeElapsedColumn(),
            )
            with Bar(*columns, console=self.console, transient=True) as bar:
                task = bar.add_task(what, total=total)
                done = -1

                def advance(text: str) -> None:
                    nonlocal done
                    done += 1
                    bar.update(task, completed=done, description=f"{what}: {text}")

                yield advance
        else:
            yield self._lines(what, total)

    def say(self, text: str) -> None:
        """One line."""
        if not self.quiet:
            self.console.print(text, highlight=False, markup=False, soft_wrap=True)

    @staticmethod
    def _lines(what: str, total: int) -> Callable[[str], None]:
        last = -EVERY
        count = 0

        def advance(text: str) -> None:
            nonlocal last, count
            count += 1
            if time.monotonic() - last >= EVERY or count == total:
                last = time.monotonic()
                sys.stderr.write(f"{what} {count}/{total}: {text}\n")

        return advance
