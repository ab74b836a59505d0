"""The files in a folder that are ours: those that a file of ours lists. All others are somebody else's, and stay."""

import json
from collections.abc import Iterable, Sequence
from contextlib import suppress
from pathlib import Path


def content(path: Path) -> dict[str, object]:
    """The content of a JSON file of ours; empty where there is none, or what somebody made of it."""
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return {}
    return found if isinstance(found, dict) else {}


def own(folder: Path, listed: object, patterns: Sequence[str]) -> list[str]:
    """The files of a list, by their paths in the folder, that can be ours: they match a pattern and lie inside."""
    inside = folder.resolve()
    return [
        name
        for name in (listed if isinstance(listed, list) else [])
        if isinstance(name, str)
        and any(Path(name).match(pattern) and name.count("/") == pattern.count("/") for pattern in patterns)
        and (folder / name).parent.resolve().is_relative_to(inside)
    ]


def remove(folder: Path, names: Iterable[str]) -> None:
    """Remove files of a folder, and its folders that are empty then."""
    for name in names:
        (folder / name).unlink(missing_ok=True)
        if (folder / name).parent != folder:
            with suppress(OSError):  # not there, or not empty
                (folder / name).parent.rmdir()
