"""The committed matrices: their pages are made from their tables and from nothing else."""

import shutil
from pathlib import Path

import pytest
from realitygap.report import write_page

REFERENCE = Path(__file__).parents[2] / "results" / "reference"
FOLDERS = sorted(table.parent for table in REFERENCE.glob("*/gaps.csv"))


def test_there_are_some() -> None:
    assert {f.name for f in FOLDERS} >= {"demo", "sigmaban_kick"}


@pytest.mark.parametrize("folder", FOLDERS, ids=lambda f: f.name)
def test_the_stored_table_gives_the_stored_page(folder: Path, tmp_path: Path) -> None:
    for name in ("gaps.csv", "manifest.json"):
        shutil.copy(folder / name, tmp_path)
    same = write_page(tmp_path).read_bytes() == (folder / "report.html").read_bytes()
    assert same, f"write it again: realitygap report {folder}"  # no difference of whole pages, which takes minutes


@pytest.mark.parametrize("folder", FOLDERS, ids=lambda f: f.name)
def test_nothing_in_it_tells_of_the_machine_that_made_it(folder: Path) -> None:
    text = (folder / "manifest.json").read_text()
    assert '"/' not in text, "an absolute path"
