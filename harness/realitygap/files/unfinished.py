"""Work in progress on a disk: who works holds a lock on it, so that the next one knows what a killed process left."""

import contextlib
import fcntl
import os
import shutil
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

from realitygap.files.interrupted import uninterrupted

UNFINISHED = ".unfinished-"
"""How names of files and folders begin that are not whole yet."""
ELSEWHERE = ".realitygap-"
"""How they begin in the folder of the machine for such files."""
YOUNG = 1.0
"""s in which whoever made a file or folder comes to hold it."""


@contextlib.contextmanager
def part_folder(parent: Path, prefix: str = UNFINISHED) -> Iterator[Path]:
    """A folder for work in progress, which goes away at the end; what killed processes left there goes first."""
    sweep(parent, prefix)
    with contextlib.ExitStack() as stack:
        with uninterrupted():
            part = Path(tempfile.mkdtemp(prefix=prefix, dir=parent))
            stack.callback(_remove, part, hold(part))
        yield part


def _remove(part: Path, held: int | None) -> None:
    with uninterrupted():
        shutil.rmtree(part, ignore_errors=True)
        if held is not None:
            os.close(held)


def sweep(parent: Path, prefix: str = UNFINISHED) -> None:
    """Remove the files and folders of that prefix that no process holds."""
    for path in parent.glob(f"{prefix}*"):
        with contextlib.suppress(OSError):  # somebody else's, or already gone
            if time.time() - path.stat().st_mtime < YOUNG or path.is_symlink():
                continue
            held = hold(path)
            if held is None:
                continue
            try:
                if path.is_dir():
                    shutil.rmtree(path)
                else:
                    path.unlink()
            finally:
                os.close(held)


def hold(path: Path | int) -> int | None:
    """Hold a file, a folder or an open file for as long as the result is open; None where another process does.

    Where a file system knows no locks, everything counts as held.
    """
    handle = path if isinstance(path, int) else os.open(path, os.O_RDONLY | os.O_CLOEXEC)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        if not isinstance(path, int):
            os.close(handle)
        return None
    return handle
