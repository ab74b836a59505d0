"""Whether a recording is what its name says, by its first bytes: people rename files and mistype their ends."""

from pathlib import Path

from realitygap.files.errors import InputError

FIRST = {  # suffix -> what files of the kind begin with, and what they are called
    ".bag": (b"#ROSBAG V", "a bag of ROS 1"),
    ".db3": (b"SQLite format 3\0", "an SQLite database"),
    ".mcap": (b"\x89MCAP0\r\n", "an MCAP file"),
    ".parquet": (b"PAR1", "a Parquet file"),
}
BAGS = (".bag", ".db3", ".mcap")
PACKED = {".gz": (b"\x1f\x8b", "packed with gzip"), ".zst": (b"\x28\xb5\x2f\xfd", "packed with Zstandard")}
"""The same of packed files, whose suffix stands behind that of what they hold."""
POINTER = b"version https://git-lfs"
"""How a file begins that `git clone` left out and git-lfs would fetch."""
ENOUGH = 64
"""Bytes that tell text from other things."""


def check_fetched(path: Path, start: bytes) -> None:
    """Make sure that a file, which begins so, is here.

    Raises:
        InputError: for one that git-lfs has not fetched.
    """
    if start.startswith(POINTER):
        raise InputError(f"{path}: is a pointer of git-lfs, not the data; expected these: run `git lfs pull`")


def check_kind(path: Path, plain: Path) -> None:
    """Make sure that a file is no other kind of recording than its name says. One that cannot be told by its first
    bytes, as where they are damaged, is left to its reader.

    Args:
        path: the recording as the user knows it.
        plain: the file itself, unpacked.

    Raises:
        InputError: for a file of another kind.
        OSError: for one that cannot be read.
    """
    with plain.open("rb") as file:
        start = file.read(ENOUGH)
    check_fetched(path, start)
    own = plain.suffix.lower()
    for suffix, (first, called) in FIRST.items():
        if start.startswith(first):
            if suffix == own:
                return
            raise InputError(f"{path}: is {called}; expected a name with {suffix} for it: rename it")
    for suffix, (first, how) in PACKED.items():
        if start.startswith(first):
            raise InputError(
                f"{path}: is {how}; expected a name with {suffix} for it: rename it to {path.name}{suffix}"
            )
    if own in FIRST and start.isascii() and (words := start.decode().split()) and "".join(words).isprintable():
        raise InputError(
            f"{path}: {'the bag cannot be read' if own in BAGS else 'is not a table'}: it is text; expected "
            f"{FIRST[own][1]}: rename it to .csv where it is a table with a header line"
        )
