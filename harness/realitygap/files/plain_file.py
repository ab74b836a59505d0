"""Files that people give are files: no device that never ends, no pipe that nobody writes to, nothing huge as text."""

import stat
from pathlib import Path

from realitygap.files.errors import InputError

LARGEST_TEXT = 64 << 20
"""Bytes of a file that people write: scenarios, matrices, benches, animations."""


def check_plain(path: Path) -> None:
    """Make sure that what is there is a file or a folder.

    Raises:
        InputError: for a pipe, a socket or a device.
    """
    try:
        mode = path.stat().st_mode
    except OSError:
        return  # told by whoever opens it
    if not (stat.S_ISREG(mode) or stat.S_ISDIR(mode)):
        raise InputError(f"{path}: is a pipe, a socket or a device; expected a file")


def read_written(path: Path) -> str:
    """The text of a file that people write.

    Raises:
        InputError: for what is no file, or no text of a size that people write.
        OSError, UnicodeDecodeError: as reading does.
    """
    check_plain(path)
    size = path.stat().st_size
    if size > LARGEST_TEXT:
        raise InputError(f"{path}: holds {size >> 20} MiB, expected at most {LARGEST_TEXT >> 20} MiB of text")
    return path.read_text(encoding="utf-8")
