"""A diagnosis that is written into the folder of an earlier one leaves nothing of it that contradicts."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from realitygap.diagnose.result.diagnosis import Diagnosis
from realitygap.diagnose.result.workflow import write_diagnosis
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
