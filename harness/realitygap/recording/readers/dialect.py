"""How a table of text is written: what separates its cells, its decimal mark, and where its header stands."""

import codecs
import re
from dataclasses import dataclass
from itertools import takewhile
from pathlib import Path
from typing import Any

HEAD = 1 << 16
"""Bytes that are looked at."""
COMMENT = ("#", "%")
MARKS = {
    codecs.BOM_UTF32_LE: "utf-32",
    codecs.BOM_UTF32_BE: "utf-32",
    codecs.BOM_UTF16_LE: "utf-16",
    codecs.BOM_UTF16_BE: "utf-16",
}
"""Marks at the begin of a file, and the encodings that they say; the longer ones first, as one begins like another."""
STATED = re.compile(r"""(?P<quote>"?)sep=(?P<separator>[;,|\t])(?P=quote)[;,|\t]*""", re.IGNORECASE)
"""The line that spreadsheets write above a table to say what separates its cells."""
ABSENT = (
    *("-", "--", "---", "k.A.", "k. A.", "#NV", "#WERT!", "#BEZUG!", "#ZAHL!", "#DIV/0!"),
    *("#VALUE!", "#REF!", "#NUM!", "#NULL!"),
)
"""What stands in a cell without a reading, beside what pandas knows as such (n/a, NaN, null, ...)."""
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
            "na_values": ABSENT,
            "skiprows": self.skipped,
            "encoding": self.encoding,
            **header,
            **spaced,
        }

    def cut_off(self, path: Path, columns: int) -> bool:
        """Whether a file ends within a line: without its end, and with fewer cells than there are columns."""
        with path.open("rb") as file:
            mark = b"" if self.encoding not in MARKS.values() else file.read(4)
            size = file.seek(0, 2)
            file.seek(max(0, size - HEAD) // 4 * 4)  # where a character begins, also of four bytes
            tail = file.read()
        line = (mark + tail).decode(self.encoding, errors="replace").rpartition("\n")[2]
        return bool(line.strip()) and len(re.split(_split(self.separator), line.strip())) < columns


def dialect_of(path: Path) -> Dialect:
    """How a file is written, from its first lines.

    Cells are separated by the first of semicolon, tab, comma and white space that stands in the header, or by what a
    first line as `sep=;` says, which spreadsheets write; the decimal mark is a comma where numbers have one that
    separates nothing. The header may stand in the last of some lines of comment (# or %) above the numbers, or above a
    row with text in it that begins with a number, as `rostopic echo -p` writes.
    """
    with path.open("rb") as file:
        head = file.read(HEAD)
    encoding = _encoding(head)
    lines = head.decode(encoding, errors="replace").splitlines()
    stated = STATED.fullmatch(lines[0]) if lines else None
    first = 0 if stated is None else 1

    def separator_of(line: str) -> str:
        return _separator(line) if stated is None else str(stated["separator"])

    comments = takewhile(lambda line: line.lstrip().startswith(COMMENT), lines[first:])
    above = first + len(list(comments))
    body = [line for line in lines[above : 21 + above] if line.strip()]
    if not body:
        return Dialect(",", ".", 0, None, encoding)
    header = body[0]
    names = None
    if above > first:
        last = lines[above - 1].lstrip().lstrip("".join(COMMENT)).strip()
        named = tuple(cell.strip().strip('"') for cell in re.split(_split(separator_of(last)), last))
        if _numbers(body[0], separator_of(body[0])) or _names(named, body[0], separator_of(last)):
            header, names = last, named
    separator = separator_of(header)
    rows = lines[above + 1 :] if names is None else lines[above:]
    decimal = "," if separator != "," and any(re.search(r"\d,\d", r) for r in rows) else "."
    return Dialect(separator, decimal, above, names, encoding)


def _encoding(head: bytes) -> str:
    """The encoding of a file with such first bytes.

    Raises:
        UnicodeError: for what is no text, or in an encoding that nothing marks.
    """
    marked = next((encoding for mark, encoding in MARKS.items() if head.startswith(mark)), None)
    if marked is not None:
        return marked
    if b"\0" in head.partition(b"\n")[0]:
        raise UnicodeError("its first line holds zeros, as what is no text, and as UTF-16 without its byte-order mark")
    try:
        head[: head.rfind(b"\n") + 1].decode("utf-8")
        return "utf-8-sig"
    except UnicodeDecodeError:
        return "utf-8" if b"\0" in head else "latin-1"  # a degree sign from elsewhere; what has zeros is no text


def _separator(header: str) -> str:
    found = next((mark for mark in (";", "\t", ",") if mark in header), None)
    return found or (r"\s+" if len(header.split()) > 1 else ",")


def _split(separator: str) -> str:
    return separator if separator == r"\s+" else re.escape(separator)


def _names(named: tuple[str, ...], line: str, separator: str) -> bool:
    """Whether words of a comment are the names of the cells of a line."""
    cells = [cell.strip() for cell in re.split(_split(separator), line.strip())]
    return (
        len(cells) == len(named) > 1
        and bool(cells[0] and NUMBER.fullmatch(cells[0]))
        and not any(cell and NUMBER.fullmatch(cell) for cell in named)
    )


def _numbers(line: str, separator: str) -> bool:
    """Whether all cells of a line are numbers."""
    return all(NUMBER.fullmatch(cell.strip()) for cell in re.split(_split(separator), line.strip()))
