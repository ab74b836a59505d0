"""What a bag may cost before its messages are looked at: how far it unpacks, and how long its definitions are.

`rosbags` unpacks a chunk whatever it grows to, and reads a definition whatever its length. For as long as a bag is
open, its unpackers and its parsers are these, which have limits.
"""

import bz2
import re
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, Literal

import rosbags.highlevel.anyreader
import rosbags.rosbag1.reader
import rosbags.rosbag2.reader
import rosbags.rosbag2.storage_mcap
from lz4.frame import LZ4FrameDecompressor

from realitygap.files.errors import InputError
from realitygap.files.unpacked import LEAST, TIMES

LINES = 100_000
"""Lines of all definitions of messages together: some seconds. Those of a large robot have 20,000."""
OF_ONE = 5_000
"""Lines of one definition, whose cost grows with their square. The longest of ROS has some hundred."""
CHARACTERS = 8 << 20
"""And their characters."""
PARSERS = ("get_types_from_msg", "get_types_from_idl")
zstd: Any = vars(rosbags.rosbag2.reader)["zstd"]
"""The module that the reader has for Zstandard, which is another one from Python 3.14 on."""
UNPACKERS: dict[str, Callable[[], Any]] = {
    "lz4": LZ4FrameDecompressor,
    "zstd": zstd.ZstdDecompressor,
    "bz2": bz2.BZ2Decompressor,
}
"""What unpacks one frame, and leaves what lies behind it."""


@dataclass
class Allowance:
    """What is left of a bag's allowance."""

    path: Path
    most: int
    unpacked: int = 0
    lines: int = 0
    characters: int = 0
    known: dict[tuple[str, ...], Any] = field(default_factory=dict)

    def count(self, size: int) -> None:
        """Note how many bytes were unpacked.

        Raises:
            InputError: where it is more than the bag may unpack to.
        """
        self.unpacked += size
        if self.unpacked > self.most:
            raise InputError(
                f"{self.path}: unpacks to more than {self.most >> 20} MiB, {TIMES} times its size; expected a "
                "recording: write it again without compression where it is one"
            )

    def unpack(self, method: str, data: bytes, *_: int) -> bytes:
        """What packed bytes hold: one frame after the other.

        Raises:
            InputError: where the bag unpacks to more than it may.
            EOFError: for bytes that were cut off.
        """
        out = []
        while data:
            one = UNPACKERS[method]()
            out.append(one.decompress(data, self.most - self.unpacked + 1))
            self.count(len(out[-1]))
            if not one.eof:
                raise EOFError("packed data was cut off")
            data = one.unused_data or b""
        return b"".join(out)

    def parse(self, parser: Callable[..., Any], text: str, *name: str) -> Any:
        """The types in a definition, each text read once.

        Raises:
            InputError: where definitions are longer than any robot's.
        """
        key = (text, *name)  # a name has a definition in ROS's own language only
        if key not in self.known:
            self.lines += text.count("\n") + 1
            self.characters += len(text)
            longest = max(one.count("\n") for one in re.split(r"^=+$", text, flags=re.MULTILINE))
            if self.lines > LINES or longest > OF_ONE or self.characters > CHARACTERS:
                raise InputError(
                    f"{self.path}: its message definitions have more than {LINES:,} lines, {OF_ONE:,} in one, or "
                    f"{CHARACTERS >> 20} MiB; expected those of messages: record it again"
                )
            self.known[key] = parser(text, *name)
        return self.known[key]


class _Packed:
    """A packed file while it is copied, which reads as much as the limits leave; and the module that opens it."""

    def __init__(self, limits: Allowance) -> None:
        self._limits = limits
        self._file: Any = None

    def decompress(self, data: bytes) -> bytes:
        return self._limits.unpack("zstd", data)

    def open(self, file: Any, mode: Literal["rb"]) -> "_Packed":
        self._file = zstd.open(file, mode)
        return self

    def __enter__(self) -> "_Packed":
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()

    def read(self, size: int) -> bytes:
        data: bytes = self._file.read(size)
        self._limits.count(len(data))
        return data


@contextmanager
def limited(path: Path) -> Iterator[Allowance]:
    """The limits of a bag, a file or a folder, which hold for as long as this is open."""
    files = [path] if path.is_file() else [p for p in path.iterdir() if p.is_file()]
    limits = Allowance(path, max(TIMES * sum(p.stat().st_size for p in files), LEAST))
    any_reader = rosbags.highlevel.anyreader
    with ExitStack() as stack:
        for table in (rosbags.rosbag1.reader.decompressors, rosbags.rosbag2.storage_mcap.DECOMPRESSORS):
            own = {method: partial(limits.unpack, method) for method in UNPACKERS if method in table}
            stack.enter_context(_replaced(table, own))
        parsers = {name: partial(limits.parse, getattr(any_reader, name)) for name in PARSERS}
        stack.enter_context(_replaced(vars(any_reader), parsers))
        stack.enter_context(_replaced(vars(rosbags.rosbag2.reader), {"zstd": _Packed(limits)}))
        yield limits


@contextmanager
def _replaced(table: dict[str, Any], others: dict[str, Any]) -> Iterator[None]:
    """A table with other entries for as long as this is open."""
    before = {name: table[name] for name in others}
    table.update(others)
    try:
        yield
    finally:
        table.update(before)
