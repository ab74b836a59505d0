"""Reading a table of text as its header says: no column becomes names of rows, and names that stand twice are known."""

import csv
import warnings
from collections import Counter
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import pandas as pd

from realitygap.files.errors import InputError

TWICE = "twice"
"""The attribute of a table under which the names are that stand more than once in its header."""


def text_table(path: Path, **how: Any) -> pd.DataFrame:
    """`pandas.read_csv(path, **how)`; separators at the ends of rows are no cells.

    Raises:
        ValueError: for an empty file, rows with more cells than the header has names, and whatever pandas raises.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("error", pd.errors.ParserWarning)
        try:
            frame: pd.DataFrame = pd.read_csv(path, index_col=False, **how)
        except pd.errors.ParserWarning:
            raise ValueError(
                "its rows have more cells than its header has names: name every column, and take another separator "
                "than the decimal mark"
            ) from None
        except pd.errors.EmptyDataError:
            raise ValueError("it is empty") from None
        except pd.errors.ParserError:
            _check_crowded(path, how)
            raise
    if "names" not in how:  # pandas gives a name that stands twice a number
        header = pd.read_csv(path, **how, header=None, nrows=1, dtype=str, index_col=False)
        frame.attrs[TWICE] = twice(header.iloc[0].dropna())
    return frame


def check_short(path: Path, width: int, **how: Any) -> None:
    """Make sure that no line has fewer than `width` cells, but for the last one, as of a file that was cut off: what
    a line lacks may have been lost anywhere in it.

    Raises:
        ValueError: for a line that has.
    """
    short = None
    for line, cells in _lines(path, how):
        if short is not None:
            raise ValueError(_uneven(*short, width))
        short = (line, cells) if cells < width else None


def _check_crowded(path: Path, how: dict[str, Any]) -> None:
    """Raise in our own words what pandas raises for a line with more cells than the header, or the first row, has."""
    lines = _lines(path, how)
    header = len(how["names"]) if "names" in how else next(lines)[1]
    most = header
    for i, (line, cells) in enumerate(lines):
        if i == 0:
            most = max(header, cells)  # separators at the ends of all rows
        elif cells > most:
            raise ValueError(_uneven(line, cells, header)) from None


def _lines(path: Path, how: dict[str, Any]) -> Iterator[tuple[int, int]]:
    """The lines of a table that are not empty: their numbers in the file, and how many cells each has."""
    separator, comment = how.get("sep", ","), how.get("comment")
    with path.open(encoding=how.get("encoding"), errors="replace") as file:
        for number, line in enumerate(file, 1):
            if number <= how.get("skiprows", 0) or not line.strip() or (comment and line.startswith(comment)):
                continue
            if separator == r"\s+":
                yield number, len(line.split())
            elif '"' in line:
                yield number, len(next(csv.reader([line], delimiter=separator, skipinitialspace=True)))
            else:
                yield number, line.count(separator) + 1


def _uneven(line: int, cells: int, header: int) -> str:
    return f"line {line} has {cells} cell{'s' * (cells != 1)}, the header {header}"


def twice(names: Iterable[str]) -> list[str]:
    """The names that stand more than once, white space around them left out."""
    return [name for name, count in Counter(name.strip() for name in names).items() if count > 1]


def once(path: Path, name: str, attributes: dict[Any, Any]) -> None:
    """Make sure that it is known which column is meant.

    Raises:
        InputError: for a name that stands twice in the header.
    """
    if name in attributes.get(TWICE, ()):
        raise InputError(f"{path}: has more than one column {name}; expected one: rename or remove the others")
