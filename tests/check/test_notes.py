"""What `check` notes of recordings beside mistakes: readings that are not taken, and what was done about rows."""

import sys
from pathlib import Path

import pandas as pd
import pytest
from realitygap.check.observed import observe
from realitygap.cli.main import main
from realitygap.scenario.file import load_scenario
from realitygap.simulate.experiment import experiments

sys.path.insert(0, str(Path(__file__).parent))  # plain modules, not a package

from teams import Team, demo


@pytest.fixture(scope="module")
def team() -> Team:
    return demo()


def notes(path: Path, capsys: pytest.CaptureFixture[str]) -> list[str]:
    """The notes on a scenario without mistakes."""
    with pytest.raises(SystemExit) as ended:
        main(["check", str(path)])
    assert not ended.value.code
    *said, last = capsys.readouterr().out.splitlines()
    assert last == "no mistake found"
    return [line.removeprefix("note: ") for line in said]


@pytest.mark.parametrize("value", [50.0, 1e300])
def test_a_reading_that_is_not_taken_is_told(
    value: float, team: Team, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    garbled = team.copy()
    garbled.tables["chirp_1"].position[100, 1] = value
    (note,) = notes(garbled.write(tmp_path), capsys)
    assert note.startswith(f"chirp_1: 1 position reading of elbow jumps far away and back ({value:.4g} at ")


def test_rows_that_came_in_no_order_are_told(team: Team, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = team.write(tmp_path)
    table = tmp_path / "chirp_1.csv"
    frame = pd.read_csv(table).sample(frac=1.0, random_state=1)
    frame.to_csv(table, index=False)
    back = (frame["time"].diff() < 0).sum()
    assert notes(path, capsys) == [f"chirp_1: {back} rows came out of order and were sorted"]


def test_rows_that_are_the_same_are_told_and_nothing_is_lost(
    team: Team, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = team.write(tmp_path)
    table = tmp_path / "chirp_1.csv"
    frame = pd.read_csv(table)
    pd.concat([frame, frame]).sort_values("time").to_csv(table, index=False)
    repeated = f"chirp_1: {len(frame)} rows repeat the time of another and were dropped, of {2 * len(frame)}"
    assert notes(path, capsys) == [repeated]
    assert [lack.kind for o in observe(load_scenario(path)) for lack in o.recording.absent] == ["copies"]


def test_a_topic_that_tables_do_not_take_is_told(
    team: Team, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    exported = team.copy()
    exported.scenario["recordings"]["state"] = "/joint_states"
    path = exported.write(tmp_path)
    (note,) = notes(path, capsys)
    assert note.startswith("recordings.state: is for bags, and not used; found a table, ")
    assert all(note in e.notes for e in experiments(load_scenario(path))), "a run and a diagnosis say it, too"
