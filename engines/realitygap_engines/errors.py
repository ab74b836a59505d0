"""What goes wrong, under one root: `except RealityGapError` catches all that this project raises on purpose.

A robot or other input that cannot be used is a `ModelError` here and an `InputError` in `realitygap`; both are
`ValueError`s, too. `Unsupported` and `Diverged` are outcomes of a simulation rather than mistakes.
"""

from typing import Any


class RealityGapError(Exception):
    """The root of all errors of this project. The message is one sentence for a person."""


class ModelError(RealityGapError, ValueError):
    """A robot description that cannot be simulated; the message says what was found and what was expected."""


class Unsupported(RealityGapError):
    """An engine was asked for physics that it cannot express; the message says what, why and what can be done."""


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
