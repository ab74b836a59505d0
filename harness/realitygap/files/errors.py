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


class InputTypeError(InputError, TypeError):
    """An argument of the library that is of no type it could have."""


@contextmanager
def standing(at: str, *, file: object = None) -> Iterator[None]:
    """Say of what is wrong in here where it stands, as in `scenario.yaml: effects[1].torque`.

    Args:
        at: what every sentence begins with.
        file: a sentence that begins with this file says it already.
    """
    try:
        yield
    except InputError as error:
        if file is not None and str(error).startswith(f"{file}: "):
            raise
        raise InputError(f"{at}{error}") from None


@contextmanager
def spared(what: str, failures: list[str]) -> Iterator[None]:
    """What fails in here costs itself alone: a sentence on it is added to the failures, and the work goes on."""
    try:
        yield
    except Exception as error:
        failures.append(f"{what} could not be made ({type(error).__name__}: {in_a_line(error)}); all else is there")


SHORTEST = 3
"""Letters from which on a part of a name says which name is meant."""
FEW = 3
"""Names that a hint has at most; where more are meant alike, none is."""
ALIKE = 0.6
"""How alike the letters of a misspelt name and of the one that was meant are, of 1."""


def did_you_mean(found: object, known: Iterable[str]) -> str:
    """The end of such a sentence: the known names whose letters are near to what was found, "" where none are.

    Near is a name that holds what was found, or that it begins with, and else the one that is most alike; of names
    with dots every part has to be.
    """
    own, names = str(found).lower(), {name.lower(): name for name in known}
    near = [name for name in names if _holds(name, own)]
    if not near:
        near = sorted((n for n in names if _alike(n, own) >= ALIKE), key=lambda n: -_alike(n, own))[:1]
    if not near or len(near) > FEW:
        return ""
    *others, last = (names[name] for name in near)
    return f"; did you mean {', '.join(others)}{' or ' if others else ''}{last}?"


def meant_first(found: object, known: Iterable[str], what: str) -> str:
    """The end of such a sentence where many names are known: what was meant, as far as that is clear, then all."""
    names = list(known)
    hint, listed = did_you_mean(found, names), f"{what}: {', '.join(names)}"
    return f"{hint} ({listed})" if hint else f"; {listed}"


def _holds(name: str, found: str) -> bool:
    return min(len(name), len(found)) >= SHORTEST and (found in name or found.startswith(name))


def _alike(name: str, found: str) -> float:
    a, b = name.split("."), found.split(".")
    pairs = zip(a, b, strict=True) if len(a) == len(b) else [(name, found)]
    return min(difflib.SequenceMatcher(None, x, y).ratio() for x, y in pairs)
