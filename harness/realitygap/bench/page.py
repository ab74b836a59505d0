"""The page of a bench procedure: what it found, section by section, with its figures; one file that opens offline."""

import base64
import re
from collections.abc import Sequence
from itertools import groupby
from pathlib import Path

from realitygap.bench.summary import Summary
from realitygap.files.whole import write_whole
from realitygap.page.shell import render

PICTURES = {".png": "image/png", ".svg": "image/svg+xml"}
SENTENCE = re.compile(r"(?!<|\w+: \[)(?=\S+ \S+ \S)((?!  ).)+")
"""A line of words: not the columns of a table, which two spaces part, nor what is meant for a URDF or a scenario."""


def write_page(summary: Summary, title: str, out: Path) -> Path:
    """Write `report.html` into a result folder. Returns it.

    Args:
        summary: what was found.
        title: of the page: what was on the bench.
        out: the result folder.
    """
    page = out / "report.html"
    figures = [(f.name, _embedded(f)) for f in summary.files if f.suffix in PICTURES]
    files = [f.relative_to(out).as_posix() if f.is_relative_to(out) else str(f) for f in summary.files]
    text = render(
        "realitygap.bench",
        "bench.html.j2",
        title=title,
        parts=[(name, blocks(text)) for name, text in sections(summary.lines)],
        figures=figures,
        files=files,
    )
    write_whole(page, text)
    return page


def sections(lines: Sequence[str]) -> list[tuple[str, str]]:
    """The lines of a summary as titles and texts; what stands before the first heading has none."""
    out: list[tuple[str, list[str]]] = [("", [])]
    for line, below in zip(lines, [*lines[1:], ""], strict=True):
        if line and below == "-" * len(line):
            out.append((line, []))
        elif not line or line != "-" * len(out[-1][0]):
            out[-1][1].append(line)
    found = [(title, "\n".join(text).strip("\n")) for title, text in out]
    return [(title, text) for title, text in found if title or text]


def blocks(text: str) -> list[tuple[bool, list[str]]]:
    """A text as sentences (True), which flow as paragraphs, and other lines, which stay as they are aligned."""
    found = groupby(text.split("\n"), key=lambda line: bool(SENTENCE.fullmatch(line)))
    parted = [(prose, list(lines)) for prose, lines in found]
    return [(prose, lines) for prose, lines in parted if any(lines)]


def _embedded(picture: Path) -> str:
    data = base64.b64encode(picture.read_bytes()).decode("ascii")
    return f"data:{PICTURES[picture.suffix]};base64,{data}"
