"""Files that people give are files: no device that never ends, no pipe that nobody writes to, nothing huge as text."""

import stat
from pathlib import Path

from realitygap.files.errors import InputError

LARGEST_TEXT = 64 << 20
"""Bytes of a file that people write: scenarios, matrices, benches, animations."""

UTF_16 = (b"\xff\xfe", b"\xfe\xff")
"""How text in UTF-16 begins, as some editors save it."""


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
        OSError: as reading does.
        ValueError: for what is no text in UTF-8, in the words of a sentence on that file.
    """
    check_plain(path)
    size = path.stat().st_size
    if size > LARGEST_TEXT:
        raise InputError(f"{path}: holds {size >> 20} MiB, expected at most {LARGEST_TEXT >> 20} MiB of text")
    data = path.read_bytes()
    try:
        return data.decode("utf-8").replace("\r\n", "\n").replace("\r", "\n")  # as a file that is opened for text
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        what = "text in UTF-16" if data.startswith(UTF_16) else f"no text in UTF-8, as line {line} shows"
        raise ValueError(f"{what}; expected UTF-8: save it with this encoding") from None
