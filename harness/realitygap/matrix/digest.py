"""Keys by content: equal for equal physics, whatever the files are called and wherever they lie."""

import dataclasses
import hashlib
from collections.abc import Mapping
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import realitygap_engines as engines
from pydantic import BaseModel

import realitygap

NAMES_ONLY = ("path", "files", "episode", "notes", "receive_time")
"""Fields that tell where something came from, and change no result."""
ROOMS = ("files", "trace", "scenario", "recording", "robot", "simulate", "compare")
"""The rooms that compute a cell; `realitygap_engines` counts as a whole."""
COMPUTES = "matrix/task.py"
"""The file that puts them together."""


class Digest:
    """SHA-256 of nested data. What was digested once is remembered as long as this object lives."""

    def __init__(self) -> None:
        self._known: dict[int, tuple[object, bytes]] = {}

    def of(self, value: Any) -> str:
        """The digest as text."""
        return self._bytes(value).hex()

    def _bytes(self, value: Any) -> bytes:
        big = isinstance(value, np.ndarray) or dataclasses.is_dataclass(value)
        if big and id(value) in self._known:
            return self._known[id(value)][1]
        found = _of_array(value) if isinstance(value, np.ndarray) else hashlib.sha256(self._content(value)).digest()
        if big:
            self._known[id(value)] = value, found  # holding the value keeps its id from being given away
        return found

    def _content(self, value: Any) -> bytes:
        kind = type(value).__name__.encode()
        if value is None or isinstance(value, bool | int | float | str | bytes | np.generic):
            return kind + repr(value).encode()
        if isinstance(value, BaseModel):
            return kind + self._bytes(value.model_dump())
        if isinstance(value, Mapping):
            return kind + b"".join(sorted(self._bytes(k) + self._bytes(v) for k, v in value.items()))
        if isinstance(value, list | tuple):
            return b"list" + b"".join(self._bytes(v) for v in value)
        if dataclasses.is_dataclass(value) and not isinstance(value, type):
            fields = {f.name: getattr(value, f.name) for f in dataclasses.fields(value) if f.name not in NAMES_ONLY}
            return kind + self._bytes(fields)
        raise TypeError(f"{type(value).__name__} has no content that could be digested")


def _of_array(value: np.ndarray[Any, Any]) -> bytes:
    kind = f"{value.dtype.descr if value.dtype.names else value.dtype.str}{value.shape}"
    digest = hashlib.sha256(b"ndarray" + kind.encode())
    if value.size:
        digest.update(np.ascontiguousarray(value).reshape(-1).view(np.uint8).data)
    return digest.digest()


@cache
def code_version() -> str:
    """A digest of the code that computes cells and of the numerical packages below it."""
    return code_digest(Path(engines.__file__ or "").parent, Path(realitygap.__file__ or "").parent)


def code_digest(engines_package: Path, package: Path) -> str:
    """The same for packages that lie in these folders: the rooms that compute a cell, and what puts them together."""
    digest = hashlib.sha256()
    rooms = [(engines_package, engines_package), *((package, package / room) for room in ROOMS)]
    files = [(top, file) for top, room in rooms for file in sorted(room.rglob("*.py"))]
    for top, file in [*files, (package, package / COMPUTES)]:
        digest.update(file.relative_to(top).as_posix().encode())
        digest.update(file.read_bytes())
    for name in ("numpy", "scipy", "numba"):
        digest.update(version(name).encode())
    return digest.hexdigest()
