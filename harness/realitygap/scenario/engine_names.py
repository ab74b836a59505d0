"""The one test that an engine's name is known and that the engine is installed."""

from collections.abc import Iterable, Sequence

import realitygap_engines as engines

from realitygap.files.errors import InputError, InputTypeError, did_you_mean
from realitygap.files.found import shown

OPTION = "--engine"


def engine_names(names: Sequence[str], where: str = OPTION) -> list[str]:
    """The engines asked for, each once, or all that are installed where none is.

    Args:
        names: as a person wrote them.
        where: the option, or the file and key, that they were written at.

    Raises:
        InputError: for an engine that does not exist or is not installed.
    """
    for name in names:
        if name not in engines.ENGINES:
            known = sorted(engines.ENGINES)
            several = "," in str(name) or " " in str(name).strip()
            hint = f"; name each on its own: {where} A {where} B" if several and where == OPTION else ""
            raise InputError(
                f"{where}: found {name}; expected one of {', '.join(known)}{hint or did_you_mean(name, known)}"
            )
        if name not in engines.available():
            raise InputError(f"{where}: {name} is not installed; install it with: {engines.ENGINES[name].install}")
    return list(dict.fromkeys(names)) or engines.available()


def given_engines(engines: str | Sequence[str] | None) -> list[str]:
    """The engines that a program asks for; none where it leaves them out, which stands for all.

    Raises:
        InputError: for a list of none, as of a filter that nothing passed: it stands for nothing.
    """
    if engines is None:
        return []
    if not isinstance(engines, Iterable):
        raise InputTypeError(f"engines: found {shown(engines)}; expected names of engines")
    names = [engines] if isinstance(engines, str) else list(engines)
    if not names:
        raise InputError("engines: found an empty list; expected names of engines, or None for all that are installed")
    return names
