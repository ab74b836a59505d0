"""Numbers of a spreadsheet with points between thousands and a comma before decimals, as 1.234,5."""

import re

import pandas as pd

MARKED = re.compile(r"[-+]?\d{1,3}(\.\d{3})+,\d+")
"""A number that says what its points are."""
GROUPED = re.compile(r"[-+]?\d{1,3}(\.\d{3})+(,\d+)?")
"""One that they may be in, too."""
NOTE = "points between groups of three digits stand for thousands, as 1.234,5 among the cells says"


def without_points(frame: pd.DataFrame) -> pd.DataFrame:
    """A table with decimal commas as numbers, where a cell says that points stand between thousands; else as it is.
    The attribute `note` of the table says so then. A column in which another cell is no such number stays text.
    """
    text = [name for name in frame.columns if pd.api.types.is_string_dtype(frame[name])]
    if not any(frame[name].dropna().map(lambda cell: bool(MARKED.fullmatch(cell.strip()))).any() for name in text):
        return frame
    out = {}
    for name in text:
        numbers = pd.to_numeric(pointed(frame[name], thousands=True), errors="coerce")
        if (numbers.isna() == frame[name].isna()).all():
            out[name] = numbers
    frame = frame.assign(**out)
    frame.attrs["note"] = NOTE
    return frame


def pointed(cells: "pd.Series[str]", *, thousands: bool) -> "pd.Series[str]":
    """Cells of text with decimal commas as points, without those of thousands where there are some."""
    return (cells.map(_without, na_action="ignore") if thousands else cells).str.replace(",", ".")


def _without(cell: str) -> str:
    """A cell without points of thousands; one that has others is no number, and stays so."""
    cell = cell.strip()
    return cell.replace(".", "") if GROUPED.fullmatch(cell) else cell.replace(".", "?")
