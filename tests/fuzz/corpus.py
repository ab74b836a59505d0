"""Cases that once broke a command, by name: what makes the files and the command, and what is said of them."""

from collections.abc import Callable

from fuzz.kinds import Case

CORPUS: dict[str, tuple[Callable[[], Case], str]] = {}
