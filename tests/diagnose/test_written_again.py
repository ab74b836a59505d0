"""A diagnosis that is written into the folder of an earlier one leaves nothing of it that contradicts."""

import shlex
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from realitygap.diagnose.result.diagnosis import Diagnosis
from realitygap.diagnose.result.workflow import write_diagnosis
from realitygap.files.errors import InputError
from realitygap.report import remake
from told_story import Page


def files(folder: Path) -> set[str]:
    """The files below a folder, by their paths in it."""
    return {f.relative_to(folder).as_posix() for f in folder.rglob("*") if f.is_file()}


def linked(folder: Path) -> set[str]:
    """The files that the page of a folder leads to."""
    page = Page((folder / "report.html").read_text(encoding="utf-8"))
    return {link for link in page.links if link is not None and not link.startswith("#")}


def test_no_mended_model_stands_beside_a_diagnosis_that_has_none(
    told: Callable[[str], Diagnosis], tmp_path: Path
) -> None:
    write_diagnosis(told("explained"), tmp_path)
    first = files(tmp_path)
    assert {"revised/scenario.yaml", "revised/robot.urdf"} <= first
    assert linked(tmp_path) == first - {"report.html"}
    write_diagnosis(replace(told("no gap"), changes=(), adjusted=()), tmp_path)
    assert files(tmp_path) == {f for f in first if not f.startswith("revised/")}
    assert linked(tmp_path) == set()


def test_what_is_not_of_a_diagnosis_stays(told: Callable[[str], Diagnosis], tmp_path: Path) -> None:
    write_diagnosis(told("explained"), tmp_path)
    (tmp_path / "revised" / "robot.mjcf.xml").write_text("<mujoco/>", encoding="utf-8")  # of an earlier --mjcf
    (tmp_path / "revised" / "notes.txt").write_text("mine", encoding="utf-8")
    write_diagnosis(told("explained"), tmp_path)
    assert {"revised/notes.txt", "revised/scenario.yaml"} <= files(tmp_path)
    assert "revised/robot.mjcf.xml" not in files(tmp_path)


def test_what_makes_its_page_anew_is_told(told: Callable[[str], Diagnosis], tmp_path: Path) -> None:
    """Its curves are of simulations that the folder does not keep, so that `report` cannot draw them."""
    result, folder = told("explained"), tmp_path / "a diagnosis"
    folder.mkdir()
    write_diagnosis(result, folder)
    page = (folder / "report.html").read_bytes()
    with pytest.raises(InputError) as refused:
        remake(folder)
    command = ["realitygap", "diagnose", str(result.problem.file.path.absolute())]
    command += [word for engine in result.engines for word in ("--engine", engine)]
    assert str(refused.value) == (
        f"{folder}: holds the result of `diagnose`, which writes its page itself, of simulations that are not kept; "
        "expected a folder written by `realitygap run` or `matrix`; "
        f"`{shlex.join([*command, '--out', str(folder)])}` makes result and page anew"
    )
    assert (folder / "report.html").read_bytes() == page
