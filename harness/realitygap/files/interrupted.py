"""Ctrl-C and SIGTERM end every command alike: folders as they were, one sentence, the status that shells give."""

import atexit
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

WORDS = {signal.SIGINT: "interrupted", signal.SIGTERM: "ended by SIGTERM"}
IMPORTS = "<frozen importlib._bootstrap>"
"""The file of the interpreter's frames while a module is imported."""
SOON = 0.02
"""Seconds after which a signal that came in an import is heard again."""


class Interrupted(BaseException):
    """A signal came: `number` says which, `left` what the command leaves behind."""

    def __init__(self, number: int) -> None:
        super().__init__(number)
        self.number = number
        self.left = "nothing was written"

    def __str__(self) -> str:
        """The sentence for the user."""
        return f"{WORDS[signal.Signals(self.number)]}; {self.left}"

    @property
    def status(self) -> int:
        """The exit status."""
        return 128 + self.number


class _Held:
    """How many blocks hold signals back, the signal that came meanwhile, the one that waits for the end of an import,
    and the last that was told at once.
    """

    blocks = 0
    came: int | None = None
    later: int | None = None
    told: int | None = None


@contextmanager
def listening() -> Iterator[None]:
    """Inside, these signals raise `Interrupted`; in another thread than the main one they are left as they are."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    _Held.blocks, _Held.came, _Held.later, _Held.told = 0, None, None, None
    before = {number: signal.signal(number, _heard) for number in WORDS}
    before[signal.SIGALRM] = signal.signal(signal.SIGALRM, _heard_again)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        for number, handler in before.items():
            signal.signal(number, handler)
        atexit.register(_deaf)


def _deaf() -> None:
    """What the command had to do is done: a signal does not end the interpreter while it ends by itself."""
    for number in WORDS:
        signal.signal(number, signal.SIG_IGN)


def _heard(number: int, frame: FrameType | None) -> None:
    if _Held.blocks:
        _Held.came = number
    elif _importing(frame):  # modules that try one another out take any error for one that is not installed
        _Held.later = number
        signal.setitimer(signal.ITIMER_REAL, SOON)
    else:
        _Held.told = number
        raise Interrupted(number)


def _heard_again(_: int, frame: FrameType | None) -> None:
    if _Held.later is not None:
        number, _Held.later = _Held.later, None
        _heard(number, frame)


def _importing(frame: FrameType | None) -> bool:
    while frame is not None and frame.f_code.co_filename != IMPORTS:
        frame = frame.f_back
    return frame is not None


def interruption() -> Interrupted | None:
    """What was told and became another error on its way, as in a compiled module; None if no signal."""
    return None if _Held.told is None else Interrupted(_Held.told)


@contextmanager
def leaving(what: str) -> Iterator[None]:
    """An interruption inside leaves this behind."""
    try:
        yield
    except Interrupted as end:
        end.left = what
        raise


@contextmanager
def last() -> Iterator[None]:
    """What a command does at last: a signal that comes inside, or after it, comes too late.

    The results are there; what is being written is written whole, and the command ends as one that is done.
    """
    _Held.blocks += 1
    try:
        yield
    except BaseException:
        _Held.blocks -= 1
        raise


@contextmanager
def uninterrupted() -> Iterator[None]:
    """A signal that comes inside is heard at the end, so that what is made and what unmakes it go together."""
    _Held.blocks += 1
    try:
        yield
    finally:
        _Held.blocks -= 1
        if not _Held.blocks and _Held.came is not None:
            number, _Held.came = _Held.came, None
            raise Interrupted(number)
