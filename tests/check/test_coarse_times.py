"""Times without fractions of a second are told as what they are, and as no unit that a scenario could state."""

import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from realitygap.check import Mistake, check
from realitygap.scenario.file import load_scenario

sys.path.insert(0, str(Path(__file__).parent))  # plain modules, not a package

from teams import Team, demo


@pytest.fixture(scope="module")
def team() -> Team:
    return demo()


def told(team: Team, folder: Path, form: str | None, slower: float = 1.0) -> list[Mistake]:
    """What is found where the times are written in a form, or in whole seconds, and last so many times longer."""
    path = team.write(folder)
    for table in folder.glob("*.csv"):
        frame = pd.read_csv(table)
        time = slower * frame["time"]
        dates = pd.to_datetime(1.7e9 + time, unit="s")
        frame.assign(time=time // 1.0 if form is None else dates.dt.strftime(form)).to_csv(table, index=False)
    return [m for m in check(load_scenario(path)) if m.certainty == "certain"]


def logged(team: Team, folder: Path, resolution: float, *, again: bool = False) -> list[Mistake]:
    """What is found where times are logged to a resolution [s], or, again, one row of each is logged at all of it."""
    path = team.write(folder)
    for table in folder.glob("*.csv"):
        frame = pd.read_csv(table)
        steps = (frame["time"] / resolution).round(6) // 1.0
        if again:
            frame = frame.groupby(steps).transform("last")
        frame.assign(time=steps * resolution).to_csv(table, index=False)
    return check(load_scenario(path))


def test_times_in_tenths_of_a_second_are_coarse(team: Team, tmp_path: Path) -> None:
    (found,) = logged(team, tmp_path, 0.1)
    assert (found.kind, found.certainty, len(found.runs)) == ("coarse_times", "likely", len(team.tables))
    assert " have a resolution of 0.1 s: " in found.text


@pytest.mark.parametrize(("resolution", "again"), [(0.02, False), (0.1, True)])
def test_rows_without_which_the_motion_still_shows_or_that_are_the_same_are_fine(
    resolution: float, again: bool, team: Team, tmp_path: Path
) -> None:
    assert [m.kind for m in logged(team, tmp_path, resolution, again=again) if m.kind == "coarse_times"] == []


@pytest.mark.parametrize("form", ["%Y-%m-%d %H:%M:%S", None])
def test_times_in_whole_seconds_are_coarse(form: str | None, team: Team, tmp_path: Path) -> None:
    (found,) = told(team, tmp_path, form)
    assert (found.kind, found.key, len(found.runs)) == ("coarse_times", "recordings.runs[0].path", len(team.tables))
    name, table = next(iter(team.tables.items()))
    rows = len(table.time)
    assert f"the times of {name} have a resolution of 1 s: {rows - len(set(table.time // 1.0))} rows" in found.text
    assert f"of {rows}; expected times with fractions of a second" in found.text
    assert "ms" not in found.text


def test_dates_are_in_no_unit(team: Team, tmp_path: Path) -> None:
    """Those of samples that are seconds apart are not times in ms."""
    period = float(np.median(np.diff(next(iter(team.tables.values())).time)))
    (found,) = told(team, tmp_path, "%Y-%m-%dT%H:%M:%S.%f", slower=1.0 / period)
    assert found.kind == "coarse_times"
    assert "are 1 s apart, as those of no recorded motion; expected times with fractions of a second" in found.text


def test_dates_with_fractions_are_fine(team: Team, tmp_path: Path) -> None:
    assert told(team, tmp_path, "%Y-%m-%dT%H:%M:%S.%f") == []
