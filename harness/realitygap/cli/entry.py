"""Where the command starts: what it is made of takes a moment to import, and a signal ends it quietly then, too.

Nothing is imported here that costs time. `listening` takes the signals over as soon as a command runs.
"""

import os
import signal
import sys
from types import FrameType

WORDS = {signal.SIGINT: b"interrupted", signal.SIGTERM: b"ended by SIGTERM"}


def _end(number: int, _: FrameType | None) -> None:
    """Leave at once: an error that is raised in an import may be taken there for a module that is not installed."""
    os.write(2, b"realitygap: %s\n" % WORDS[signal.Signals(number)])
    os._exit(128 + number)


def _open_standard_streams() -> None:
    """What a service closed leads nowhere: else the next file that is opened would get what libraries print."""
    for descriptor, name in enumerate(("stdin", "stdout", "stderr")):
        try:
            os.fstat(descriptor)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # gets the lowest number that is free, which is this one
        if getattr(sys, name) is None:
            setattr(sys, name, os.fdopen(descriptor, "w" if descriptor else "r", closefd=False))


def main() -> None:
    """Entry point of `realitygap` and of `python -m realitygap`."""
    for number in WORDS:
        signal.signal(number, _end)
    _open_standard_streams()
    from realitygap.cli.main import main as command_line

    command_line()
