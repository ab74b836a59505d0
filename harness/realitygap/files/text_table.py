"""Reading a table of text as its header says: no column becomes names of rows, and names that stand twice are known."""

import warnings
from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import pandas as pd

from realitygap.files.errors import InputError

TWICE = "twice"
"""The attribute of a table under which the names are that stand more than once in its header."""


def text_table(path: Path, **how: Any) -> pd.DataFrame:
    """`pandas.read_csv(path, **how)`; separators at the ends of rows are no cells.

    Raises:
        ValueError: for rows with more cells than the header has names, and whatever pandas raises.
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
    if "names" not in how:  # pandas gives a name that stands twice a number
        header = pd.read_csv(path, **how, header=None, nrows=1, dtype=str, index_col=False)
        frame.attrs[TWICE] = twice(header.iloc[0].dropna())
    return frame


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
