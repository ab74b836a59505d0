"""Tables that a phone shows as cards: every cell knows the name of its column."""

import re

TABLE = re.compile(r'<table class="plain\b.*?</table>', re.DOTALL)
HEAD, ROWS = re.compile(r"<thead>(.*?)</thead>", re.DOTALL), re.compile(r"<tbody>.*?</tbody>", re.DOTALL)
ROW, CELL = re.compile(r"<tr>.*?</tr>", re.DOTALL), re.compile(r"<t[hd]\b([^>]*)>")
NAME, SPAN = re.compile(r"<th\b[^>]*>(.*?)</th>", re.DOTALL), re.compile(r'colspan="(\d+)"')

BREAKS = re.compile(r"(?<=[_.])(?=[^\W\d])")
"""Where a long key may be broken into lines: by a space of no width."""


def with_column_names(page: str) -> str:
    """The page with its column's name, as `data-label`, on every cell of its plain tables: page.css shows it there.

    A cell over several columns has the name of the first of them.
    """
    return TABLE.sub(lambda table: _labelled(table[0]), page)


def _labelled(table: str) -> str:
    head = HEAD.search(table)
    assert head is not None, "a plain table has the names of its columns in a head"
    names = [BREAKS.sub("\u200b", " ".join(name.replace('"', "&quot;").split())) for name in NAME.findall(head[1])]
    return ROWS.sub(lambda rows: ROW.sub(lambda row: _row(row[0], names), rows[0]), table)


def _row(row: str, names: list[str]) -> str:
    column = 0

    def cell(start: re.Match[str]) -> str:
        nonlocal column
        label, wide = names[column], SPAN.search(start[1])
        column += int(wide[1]) if wide else 1
        return f'{start[0][:-1]} data-label="{label}">'

    return CELL.sub(cell, row)
