"""Where a draft is written, and how it names the recordings: as they are found from there, and as they were given."""

from pathlib import Path

import pytest
from fuzz.template import csv, files, written
from realitygap.files.errors import InputError
from realitygap.init.draft import init
from realitygap.scenario.file import load_scenario


@pytest.mark.parametrize("place", ["out", "link", "link/out", "out/../other"])
def test_recordings_are_found_from_where_the_draft_lies(place: str, tmp_path: Path) -> None:
    written(tmp_path, files())
    (tmp_path / "far" / "away").mkdir(parents=True)
    (tmp_path / "link").symlink_to(tmp_path / "far" / "away")
    (tmp_path / "out").mkdir()
    draft = init(tmp_path / "arm.urdf", [tmp_path / "run.csv"], tmp_path / place).path
    (case,) = load_scenario(draft).cases()
    assert case.path.resolve() == tmp_path.resolve() / "run.csv"


def test_a_recording_that_cannot_be_used_is_named_as_it_was_given(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    written(tmp_path, files(run__csv=b"\n".join(csv().splitlines()[:2])))
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match=r"^run\.csv: "):
        init(Path("arm.urdf"), [Path("run.csv")], Path("new"))
    assert not Path("new").exists()
