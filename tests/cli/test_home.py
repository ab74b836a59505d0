"""`~` on the command line, where shells leave it alone: behind `=`, as in `--out=~/kick` and `--package arm=~/arm`."""

from pathlib import Path

import pytest
from realitygap.cli.main import main
from realitygap.init.draft import parse_packages
from realitygap.matrix.store import open_store


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A home folder that is not where one is."""
    (tmp_path / "home").mkdir()
    (tmp_path / "here").mkdir()
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.chdir(tmp_path / "here")
    return tmp_path / "home"


def test_results_are_whole_and_in_the_home_folder(case: Path, home: Path, capfd: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["run", str(case / "scenario.yaml"), "--engine", "mujoco", "--out=~/kick", "--junit=~/kick.xml"])
    said = capfd.readouterr()
    assert ended.value.code == 0, said.err
    assert "could not be made" not in said.err
    assert said.out.endswith(f"report: {home}/kick/report.html\n")
    assert (home / "kick" / "report.html").is_file()
    assert (home / "kick.xml").is_file()
    assert list(Path().iterdir()) == [], "something was written where one is"


def test_packages_and_cells_too(home: Path) -> None:
    (home / "arm").mkdir()
    assert parse_packages(["arm=~/arm"]) == {"arm": home / "arm"}
    open_store("~/cells").write("a", b"1")
    assert (home / "cells" / "a.zip").is_file()


def test_who_is_unknown_has_no_home(home: Path) -> None:
    """The name of a file may begin with it."""
    (home.parent / "here" / "~nobody-here").mkdir()
    assert parse_packages(["arm=~nobody-here"]) == {"arm": Path("~nobody-here")}
