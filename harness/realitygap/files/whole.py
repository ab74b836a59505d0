"""Files that are written whole or not at all, and the check, before long work, that a folder takes files."""

import contextlib
import os
import tempfile
from collections.abc import Iterator
from pathlib import Path

from realitygap.files.errors import InputError
from realitygap.files.unfinished import UNFINISHED, hold


def check_writable(folder: Path, option: str = "--out") -> None:
    """Make sure, before long work and leaving nothing behind, that a result folder can be written.

    Raises:
        InputError: where a file is in the way or the place takes no files.
    """
    place = folder.absolute()
    while not place.exists() and not place.is_symlink():
        place = place.parent
    if not place.is_dir():
        what = "a file" if place.exists() else "a link to nothing"
        raise InputError(f"{option}: {folder} cannot be made because {place} is {what}; expected a folder")
    try:
        tempfile.TemporaryFile(dir=place).close()  # permissions do not tell of read-only disks or of /proc
    except OSError as error:
        raise InputError(
            f"{option}: {folder} cannot be written, {place} takes no files ({error.strerror}); expected a folder to "
            "write to"
        ) from None


def check_writable_file(file: Path, option: str) -> None:
    """The same for one file.

    Raises:
        InputError: where a folder is in its place, or its folder cannot be written.
    """
    if file.is_dir():
        raise InputError(f"{option}: {file} is a folder; expected the name of a file")
    check_writable(file.parent, option)


@contextlib.contextmanager
def made(folder: Path) -> Iterator[None]:
    """A folder that is there, and is gone again where the work in here fails and nothing else was put there."""
    absent = [f for f in (folder, *folder.parents) if not f.exists()]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        yield
    except BaseException:
        for new in absent:
            with contextlib.suppress(OSError):
                new.rmdir()
        raise


def write_whole(path: Path, content: str | bytes) -> None:
    """Write a file whole or not at all: beside its place first, then moved there."""
    path.parent.mkdir(parents=True, exist_ok=True)
    data = content.encode("utf-8") if isinstance(content, str) else content
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=UNFINISHED)
    part = Path(name)
    try:
        with os.fdopen(handle, "wb") as file:
            hold(handle)
            file.write(data)
        part.chmod(0o644)
        part.replace(path)
    except BaseException:
        part.unlink(missing_ok=True)
        raise
