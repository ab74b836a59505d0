"""Words in a table that a spreadsheet takes for words: a name that begins like a formula is none."""

import re

FORMULA = re.compile(r"'*[=+\-@\t\r]")
"""How a formula begins; and words that look like one that was marked already, so that each comes back as it was."""


def as_words(text: str) -> str:
    """A cell's text, marked with an apostrophe where a spreadsheet would compute it."""
    return f"'{text}" if FORMULA.match(text) else text


def as_meant(cell: str) -> str:
    """The text of a cell that may be marked."""
    return cell[1:] if cell.startswith("'") and FORMULA.match(cell) else cell
