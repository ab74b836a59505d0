"""A process that does one piece of work after the other, and the handle that its parent holds.

Whatever happens to a cell happens to this process alone. The process ends when its parent is gone.
"""

import contextlib
import os
import pickle
import signal
import socket
import subprocess
import sys
from collections.abc import Callable
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from realitygap_engines.errors import in_a_line

from realitygap.files.lifeline import end_with
from realitygap.files.threads import THREADS
from realitygap.simulate.opened import kept_open

START = 300.0
"""s in which a process has to start, on however busy a machine."""
KILLS = (signal.SIGKILL, signal.SIGTERM, signal.SIGHUP, signal.SIGINT)
"""Signals that come from outside; any other end is the cell's own doing."""


class Died(Exception):
    """The process ended at its work; `killed` says that someone else ended it."""

    def __init__(self, what: str, killed: bool) -> None:
        super().__init__(what)
        self.killed = killed


class Hung(Exception):
    """The process took longer than its time limit and was ended."""


class Worker:
    """A worker process, started at once and used by one thread; its temporary files lie in a folder of its parent's."""

    def __init__(self, temporary: Path) -> None:
        self._ready = False
        ours, theirs = socket.socketpair()
        self._connection = Connection(ours.detach())
        with theirs:
            self._process = subprocess.Popen(
                [sys.executable, "-m", "realitygap.matrix.worker", str(theirs.fileno()), str(os.getpid())],
                pass_fds=[theirs.fileno()],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,  # engines greet there
                env=dict.fromkeys(THREADS, "1") | os.environ | {"TMPDIR": str(temporary)},
                process_group=0,  # Ctrl-C is the parent's to handle
            )

    @property
    def alive(self) -> bool:
        """Whether the process is there."""
        return self._process.poll() is None

    @property
    def pid(self) -> int:
        """The process's number."""
        return self._process.pid

    def run(self, work: Callable[..., Any], *arguments: Any, limit: float) -> Any:
        """Call a function of a module in the process, and return what it returns.

        Raises:
            Died: where the process ended, or the function raised something.
            Hung: where it took longer than `limit` [s].
        """
        asked = pickle.dumps((work, arguments), pickle.HIGHEST_PROTOCOL)
        try:
            if not self._ready:
                self._answer(START)
                self._ready = True
            self._connection.send_bytes(asked)
            kind, result = self._answer(limit)
        except (EOFError, OSError):
            raise self._ended() from None
        except Hung:
            self.close()
            raise
        if kind == "failed":
            raise Died(str(result), killed=False)
        return result

    def _answer(self, limit: float) -> tuple[str, Any]:
        if not self._connection.poll(limit):
            raise Hung
        kind, result = self._connection.recv()
        return str(kind), result

    def _ended(self) -> Died:
        """How the process ended, in words that are the same every time."""
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._process.wait(10)
        code = self._process.poll()
        self.close()
        if code is None or code >= 0:
            return Died(f"the process exited with status {code} in the middle of the cell", killed=False)
        name = signal.Signals(-code).name
        what = (signal.strsignal(-code) or "").lower()
        return Died(f"the process was ended by {name} ({what})", killed=-code in KILLS)

    def kill(self) -> None:
        """End the process, from any thread: the connection belongs to the one that uses it, which finds its end."""
        self._process.kill()
        self._process.wait()

    def close(self) -> None:
        """End the process and the connection to it."""
        self.kill()
        self._connection.close()


def serve(connection: Connection) -> None:
    """Do the work that comes through a connection until it is closed."""
    with contextlib.suppress(EOFError, OSError):
        connection.send(("ready", ""))
        while True:
            work, arguments = pickle.loads(connection.recv_bytes())
            try:
                result = work(*arguments)
            except Exception as error:  # whatever it is, it is what became of this work
                connection.send(("failed", f"{type(error).__name__}: {in_a_line(error)}"))
                continue
            connection.send(("done", result))


if __name__ == "__main__":
    end_with(int(sys.argv[2]))
    import realitygap.matrix.task  # noqa: F401 (what cells need is loaded before the first one is timed)

    with kept_open():
        serve(Connection(int(sys.argv[1])))
