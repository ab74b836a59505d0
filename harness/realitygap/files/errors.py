"""The one error that a person made: bad input, told in one sentence."""

import difflib
from collections.abc import Iterable

from realitygap_engines.errors import RealityGapError


class InputError(RealityGapError, ValueError):
    """Input that cannot be used.

    The message is one sentence that names the file and the key or topic, what was found, what was expected and, where
    it helps, what to do. The command line prints it and exits with status 2.
    """


def did_you_mean(found: str, known: Iterable[str]) -> str:
    """The end of such a sentence: the known name that is close to the one found, "" where none is."""
    close = difflib.get_close_matches(found, list(known), n=1)
    return f"; did you mean {close[0]}?" if close else ""
