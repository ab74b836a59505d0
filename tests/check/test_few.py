"""Recordings and windows of a few samples, or beyond them: a run warns of them, and more are none of its business."""

import sys
from pathlib import Path

import numpy as np
import pytest
from realitygap.check import certain, check
from realitygap.cli.main import main
from realitygap.scenario.file import load_scenario

sys.path.insert(0, str(Path(__file__).parent))  # plain modules, not a package

from teams import Team, demo


@pytest.fixture(scope="module")
def team() -> Team:
    return demo()


def cut(team: Team, count: int) -> Team:
    """The same with its last recording cut to its first samples."""
    out = team.copy()
    table = list(out.tables.values())[-1]
    for signal in ("time", "command", "position", "velocity", "effort"):
        setattr(table, signal, getattr(table, signal)[:count])
    return out


@pytest.mark.parametrize(("count", "told"), [(2, True), (5, True), (9, True), (10, False)])
def test_a_recording_of_a_few_samples_is_told(count: int, told: bool, team: Team, tmp_path: Path) -> None:
    found = certain(load_scenario(cut(team, count).write(tmp_path)))
    assert [m.kind for m in found] == ["few_samples"] * told
    if told:
        assert found[0].text.startswith(f"recordings.runs[5].path: sines_2 holds {count} samples in 0.0")
        assert found[0].text.endswith("expected at least 10: record longer, or get the whole file")


@pytest.mark.parametrize("key", ["window", "part"])
def test_so_is_a_window_of_a_few(key: str, team: Team, tmp_path: Path) -> None:
    spoilt = team.copy()
    period = float(np.diff(next(iter(spoilt.tables.values())).time).mean())
    spoilt.scenario["recordings"]["runs"][0][key] = [1.0, 1.0 + 3.5 * period]
    (found,) = check(load_scenario(spoilt.write(tmp_path)))
    assert (found.kind, found.certainty, found.key) == ("few_samples", "likely", f"recordings.runs[0].{key}")


def test_so_is_a_part_that_holds_for_all(team: Team, tmp_path: Path) -> None:
    (found,) = check(load_scenario(team.write(tmp_path)).override({"recordings.part": [1.0, 1.01]}))
    assert (found.kind, found.key, len(found.runs)) == ("few_samples", "recordings.part", len(team.tables))


@pytest.mark.parametrize(
    ("window", "told"),
    [([-3.0, 1.0], True), ([1.0, 200.0], True), ([-0.2, 4.8], False), ([1.0, 5.2], False), ([1.0, 4.0], False)],
)
def test_a_window_that_reaches_beyond_its_recording_is_told(
    window: list[float], told: bool, team: Team, tmp_path: Path
) -> None:
    spoilt = team.copy()
    spoilt.scenario["recordings"]["runs"][0]["window"] = window
    found = check(load_scenario(spoilt.write(tmp_path)))
    assert [(m.kind, m.certainty, m.key) for m in found] == [("window", "likely", "recordings.runs[0].window")] * told
    if told:
        assert "reaches beyond steps_1, which lasts from 0.00 to 5.0" in found[0].text


def test_a_run_warns_and_its_page_does(team: Team, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = cut(team, 3).write(tmp_path)
    with pytest.raises(SystemExit) as ended:
        main(["run", str(path), "--engine", "mujoco", "--out", str(tmp_path / "out")])
    assert ended.value.code == 0
    said = "sines_2 holds 3 samples in 0.00997 s: gaps of so few are of a moment and say nothing of a motion"
    assert said in capsys.readouterr().err
    assert said in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
