"""How a table of text is written: what separates its cells, its decimal mark, and where its header stands."""

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

HEAD = 1 << 16
"""Bytes that are looked at."""
COMMENT = ("#", "%")
NUMBER = re.compile(r"[-+]?(\d+[.,]?\d*|[.,]\d+)([eE][-+]?\d+)?|nan|inf|", re.IGNORECASE)


@dataclass(frozen=True)
class Dialect:
    """The separator (a regular expression for white space), the decimal mark, the lines above the header, the header
    where it stands in a comment, and the encoding.
    """

    separator: str
    decimal: str
    skipped: int
    names: tuple[str, ...] | None
    encoding: str

    @property
    def first_line(self) -> int:
        """The line of the file that holds the first row."""
        return self.skipped + (1 if self.names is not None else 2)

    def arguments(self) -> dict[str, Any]:
        """What `pandas.read_csv` needs to know."""
        header = {"header": None, "names": list(self.names)} if self.names is not None else {}
        spaced = {} if self.separator == r"\s+" else {"skipinitialspace": True}
        return {
            "sep": self.separator,
            "decimal": self.decimal,
            "skiprows": self.skipped,
            "encoding": self.encoding,
            **header,
            **spaced,
        }

    def cut_off(self, path: Path, columns: int) -> bool:
        """Whether a file ends within a line: without its end, and with fewer cells than there are columns."""
        with path.open("rb") as file:
            size = file.seek(0, 2)
            file.seek(max(0, size - HEAD))
            tail = file.read()
        line = tail[tail.rfind(b"\n") + 1 :].decode(self.encoding, errors="replace")
        return bool(line.strip()) and len(re.split(_split(self.separator), line.strip())) < columns


def dialect_of(path: Path) -> Dialect:
    """How a file is written, from its first lines.

    Cells are separated by the first of semicolon, tab, comma and white space that stands in the header; the decimal
    mark is a comma where numbers have one that separates nothing. The header may stand in the last of some lines of
    comment (# or %) above the numbers.
    """
    with path.open("rb") as file:
        head = file.read(HEAD)
    try:
        head[: head.rfind(b"\n") + 1].decode("utf-8")
        encoding = "utf-8-sig"
    except UnicodeDecodeError:
        encoding = "utf-8" if b"\0" in head else "latin-1"  # a degree sign from elsewhere; what has zeros is no text
    lines = head.decode(encoding, errors="replace").splitlines()
    above = next((i for i, line in enumerate(lines) if not line.lstrip().startswith(COMMENT)), len(lines))
    body = [line for line in lines[above : 21 + above] if line.strip()]
    if not body:
        return Dialect(",", ".", 0, None, encoding)
    header = body[0]
    names = None
    if above and _numbers(body[0], _separator(body[0])):
        header = lines[above - 1].lstrip().lstrip("".join(COMMENT)).strip()
        names = tuple(cell.strip().strip('"') for cell in re.split(_split(_separator(header)), header))
    separator = _separator(header)
    rows = body[1:] if names is None else body
    decimal = "," if separator != "," and any(re.search(r"\d,\d", r) for r in rows) else "."
    return Dialect(separator, decimal, above, names, encoding)


def _separator(header: str) -> str:
    found = next((mark for mark in (";", "\t", ",") if mark in header), None)
    return found or (r"\s+" if len(header.split()) > 1 else ",")


def _split(separator: str) -> str:
    return separator if separator == r"\s+" else re.escape(separator)


def _numbers(line: str, separator: str) -> bool:
    """Whether all cells of a line are numbers."""
    return all(NUMBER.fullmatch(cell.strip()) for cell in re.split(_split(separator), line.strip()))
