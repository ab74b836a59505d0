"""What goes wrong, under one root: `except RealityGapError` catches all that this project raises on purpose.

A robot or other input that cannot be used is a `ModelError` here and an `InputError` in `realitygap`; both are
`ValueError`s, too. `Unsupported`, `Failed` and `Diverged` are outcomes of a simulation rather than mistakes.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any


class RealityGapError(Exception):
    """The root of all errors of this project. The message is one sentence for a person."""


class ModelError(RealityGapError, ValueError):
    """A robot description that cannot be simulated; the message says what was found and what was expected."""


class Unsupported(RealityGapError):
    """An engine was asked for physics that it cannot express; the message says what, why and what can be done."""


class Failed(RealityGapError):
    """An engine gave up while it opened, stepped or read a robot; the message is one sentence with its own words."""


class Diverged(RealityGapError):
    """The simulation blew up: a state that is not finite or not physical, or an engine's silent reset.

    `time` [s] is the end of the step that failed and `joint` the first joint (or "base") seen to be wrong.
    """

    def __init__(self, time: float, joint: str, what: str) -> None:
        super().__init__(f"diverged at {time:.4f} s at {joint}: {what}")
        self.time = time
        self.joint = joint
        self.what = what

    def __reduce__(self) -> tuple[Any, ...]:
        """As it was made, so that it comes through from another process."""
        return type(self), (self.time, self.joint, self.what)


LONGEST = 300
"""Characters of a sentence that somebody else's words may fill."""


def in_a_line(words: object, most: int = LONGEST) -> str:
    """Words from outside in one line: control characters as they are escaped, and of what is too long both ends."""
    text = "".join(c if c.isprintable() else c.encode("unicode_escape").decode("ascii") for c in str(words))
    text = " ".join(text.split())
    return text if len(text) <= most else f"{text[: most * 2 // 3]} ... {text[-(most // 3 - 5) :]}"


@contextmanager
def as_its_outcome(engine: str) -> Iterator[None]:
    """Whatever an engine raises in here is what its simulation came to: `Failed`, with the engine's words.

    What this project raises on purpose goes through as it is, and so does a memory that is too small.
    """
    try:
        yield
    except (RealityGapError, MemoryError):
        raise
    except Exception as error:
        words = in_a_line(error)
        raise Failed(f"{engine} failed with {type(error).__name__}{f': {words}' if words else ''}") from error
