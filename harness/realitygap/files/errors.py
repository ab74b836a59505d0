"""The one error that a person made: bad input, told in one sentence."""

import difflib
from collections.abc import Iterable, Iterator
from contextlib import contextmanager

from realitygap_engines.errors import RealityGapError, in_a_line


class InputError(RealityGapError, ValueError):
    """Input that cannot be used.

    The message is one sentence that names the file and the key or topic, what was found, what was expected and, where
    it helps, what to do. The command line prints it and exits with status 2.
    """


@contextmanager
def spared(what: str, failures: list[str]) -> Iterator[None]:
    """What fails in here costs itself alone: a sentence on it is added to the failures, and the work goes on."""
    try:
        yield
    except Exception as error:
        failures.append(f"{what} could not be made ({type(error).__name__}: {in_a_line(error)}); all else is there")


def did_you_mean(found: object, known: Iterable[str]) -> str:
    """The end of such a sentence: the known name that is close to what was found, "" where none is."""
    lower = {name.lower(): name for name in known}
    close = difflib.get_close_matches(str(found).lower(), lower, n=1)
    return f"; did you mean {lower[close[0]]}?" if close else ""
