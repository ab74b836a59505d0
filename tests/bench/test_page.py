"""The page of a bench procedure: everything that the terminal says, under its headings, and the figures in one file."""

import base64
import re
from pathlib import Path

from realitygap.bench.page import sections, write_page
from realitygap.bench.summary import Summary

PIXEL = base64.b64decode(
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADhgGAWjR9awAAAABJRU5ErkJggg=="
)


def found(folder: Path) -> Summary:
    summary = Summary(["of two motors"])
    summary.section("Torque & speed")
    summary.table(["motor", "N·m"], [["left", "1.20"], ["right", "1.31"]])
    summary.section("Friction")
    summary.lines += ["coulomb 0.1 N·m", "", "WARNING: <few> samples"]
    picture = folder / "curve.png"
    picture.write_bytes(PIXEL)
    summary.files.append(picture)
    summary.write(folder / "fits.csv", "a,b\n")
    return summary


def test_headings_part_the_lines_and_nothing_is_lost(tmp_path: Path) -> None:
    summary = found(tmp_path)
    parts = sections(summary.lines)
    assert [title for title, _ in parts] == ["", "Torque & speed", "Friction"]
    assert parts[2][1] == "coulomb 0.1 N·m\n\nWARNING: <few> samples"
    said = [line for line in summary.lines if line and set(line) != {"-"}]
    assert said == [line for title, text in parts for line in [title, *text.splitlines()] if line]


def test_the_page_is_one_file_that_needs_no_other(tmp_path: Path) -> None:
    page = write_page(found(tmp_path), "knee motors", tmp_path).read_text()
    assert "<title>knee motors – bench – reality gap</title>" in page
    assert "Torque &amp; speed" in page
    assert "WARNING: &lt;few&gt; samples" in page
    (picture,) = re.findall(r'<img src="data:image/png;base64,([^"]*)"', page)
    assert base64.b64decode(picture) == PIXEL
    assert '<a href="fits.csv">' in page
    assert not re.search(r"https?://", page)
