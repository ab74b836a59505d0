"""The page of a bench procedure: everything that the terminal says, under its headings, and the figures in one file."""

import base64
import re
from pathlib import Path

from realitygap.bench.page import blocks, sections, write_page
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


def test_sentences_flow_and_columns_stay_aligned(tmp_path: Path) -> None:
    text = """motor    mean
left_1   0.06
On average the maximum torque lies +1.11 N·m from the fitted stall torque and the maximum speed +1.49 rad/s from it.
WARNING: chirp: 32% of the torque is not explained.

effects: [{effect: voltage_sag, target: "*", resistance: 0.1535}]
<!-- left at 14.8 V: the largest torque and speed that were measured -->
servos:
  - name: left
    kind: dc
with a supply of 15 V in the servos"""
    lines = text.split("\n")
    assert blocks(text) == [(False, lines[:2]), (True, lines[2:4]), (False, lines[4:10]), (True, lines[10:])]
    summary = found(tmp_path)
    summary.lines += lines
    page = write_page(summary, "knee motors", tmp_path).read_text(encoding="utf-8")
    aligned = "".join(re.findall(r"<pre[^>]*>(.*?)</pre>", page, re.DOTALL))
    assert max(map(len, aligned.split("\n"))) < 90
    assert f'<p class="said">{lines[2]}</p>' in page
    assert "  - name: left\n    kind: dc</pre>" in page


def test_the_page_is_one_file_that_needs_no_other(tmp_path: Path) -> None:
    page = write_page(found(tmp_path), "knee motors", tmp_path).read_text()
    assert "<title>knee motors – bench – reality gap</title>" in page
    assert "Torque &amp; speed" in page
    assert "WARNING: &lt;few&gt; samples" in page
    (picture,) = re.findall(r'<img src="data:image/png;base64,([^"]*)"', page)
    assert base64.b64decode(picture) == PIXEL
    assert '<a href="fits.csv">' in page
    assert not re.search(r"https?://", page)
