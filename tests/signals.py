"""What may be missing in general, as tests read it: they know what is there."""

from typing import TypeVar

from realitygap.trace.trace import Trace
from realitygap_engines.model.robot import Array

T = TypeVar("T")


def there(value: T | None) -> T:
    """The value, in a test that knows that there is one."""
    assert value is not None
    return value


class Signals:
    """The signals of a trace, by their names there; one that is not there fails the test that reads it."""

    def __init__(self, trace: Trace) -> None:
        self.trace = trace
        self.time, self.joints = trace.time, trace.joints

    def __getattr__(self, name: str) -> Array:
        signal: Array | None = getattr(self.trace, name)
        assert signal is not None, f"the trace has no {name}"
        return signal
