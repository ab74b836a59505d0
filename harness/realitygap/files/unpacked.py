"""Files that were packed with gzip or Zstandard, as plain ones for as long as they are read."""

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from realitygap.files.errors import InputError
from realitygap.files.unfinished import ELSEWHERE, part_folder

PACKED = {".gz": "gzip", ".zst": "zstd", ".zstd": "zstd"}
"""Suffixes of packed files, and what pyarrow calls the method."""
TIMES, LEAST = 100, 256 << 20
"""By how much a recording is packed at most, and the bytes that it may unpack to in any case."""
OTHERS = (".bz2", ".xz", ".zip", ".7z", ".tar", ".tgz", ".lz4")
"""Suffixes of files that have to be unpacked by hand."""


def plain_name(path: Path) -> Path:
    """The path without the suffix of its packing."""
    return path.with_suffix("") if path.suffix.lower() in PACKED else path


@contextmanager
def unpacked(path: Path) -> Iterator[Path]:
    """A plain file with what a packed one holds, which goes away afterwards; a plain file as it is.

    Raises:
        InputError: for a packed file that is broken or was cut off.
    """
    method = PACKED.get(path.suffix.lower())
    if method is None or path.is_dir():
        yield path
        return
    import pyarrow as pa  # here, because a scenario that only asks for a name is to load fast

    with part_folder(Path(tempfile.gettempdir()), ELSEWHERE) as folder:
        most = max(TIMES * path.stat().st_size, LEAST)
        plain = folder / plain_name(path).name
        try:
            with pa.input_stream(str(path), compression=method) as source, plain.open("wb") as target:
                while data := source.read(1 << 20):
                    if target.tell() > most:
                        raise InputError(
                            f"{path}: unpacks to more than {most >> 20} MiB, {TIMES} times its size; expected a "
                            "recording: unpack it first where it is one"
                        )
                    target.write(data)
        except (OSError, pa.ArrowException) as error:
            what = " ".join(str(error).split()) or type(error).__name__
            raise InputError(
                f"{path}: cannot be unpacked ({what}); expected a whole {path.suffix} file: get it again"
            ) from None
        yield plain
