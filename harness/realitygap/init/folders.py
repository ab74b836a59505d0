"""Folders that hold several recordings, as people keep those of a day: each is a run."""

from collections.abc import Sequence
from pathlib import Path

from realitygap.files.unpacked import plain_name
from realitygap.recording import INFO
from realitygap.recording.readers.storage import TABLES

BAGS = {".bag", ".db3", ".mcap"}
SHOWN = 4
"""Names that a sentence lists."""


def recordings_in(paths: Sequence[Path]) -> tuple[list[Path], list[str]]:
    """The paths with the bags of a folder, or of one without bags its tables, in its place; and what is told of that.
    A bag's own folder, a data set's, and what holds no recordings stay as they are.
    """
    out, told = list[Path](), list[str]()
    for path in paths:
        found, rest = _held(path)
        if not found:
            out.append(path)
            continue
        listed = ", ".join(p.name for p in found[:SHOWN])
        more = f" and {len(found) - SHOWN} more" if len(found) > SHOWN else ""
        spare = f"; not used of it: {', '.join(p.name for p in rest[:SHOWN])}" if rest else ""
        told.append(f"{path} holds {len(found)} recordings, of which each is a run: {listed}{more}{spare}")
        out += found
    return out, told


def _held(path: Path) -> tuple[list[Path], list[Path]]:
    """The recordings in a folder that is none itself, and the tables beside bags."""
    if not path.is_dir() or (path / "metadata.yaml").exists() or (path / INFO).exists():
        return [], []
    parts = sorted(part for part in path.iterdir() if not part.name.startswith("."))
    tables = [part for part in parts if part.is_file() and plain_name(part).suffix.lower() in TABLES]
    files = [part for part in parts if part.is_file() and plain_name(part).suffix.lower() in BAGS]
    folders = [part for part in parts if part.is_dir() and _recorded(part)]
    if folders or len(files) > 1:  # of one file alone, the folder is what a recorder left behind that was killed
        return sorted([*files, *folders]), tables
    return ([], []) if files else (tables, [])


def _recorded(folder: Path) -> bool:
    """Whether a folder is a bag or a data set."""
    stored = [part for part in folder.iterdir() if part.suffix.lower() in BAGS]
    return bool((folder / "metadata.yaml").exists() or (folder / INFO).exists() or len(stored) == 1)
