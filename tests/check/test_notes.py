"""What `check` notes of recordings beside mistakes: readings that are not taken, and what was done about rows."""

import sys
from pathlib import Path

import pytest
from realitygap.cli.main import main

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
