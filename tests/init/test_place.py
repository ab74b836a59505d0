"""Where a draft is written, and how it names the recordings: as they are found from there, and as they were given."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from first_scenario import arm, messages
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


def test_an_effort_that_one_table_lacks_is_told_of_it_and_of_no_file_that_is_not_there(tmp_path: Path) -> None:
    clock = np.arange(100) * 0.01
    frame = pd.DataFrame({"time": clock})
    for signal in ("command", "position", "effort"):
        frame[f"{signal}_shoulder"] = frame[f"{signal}_elbow"] = np.sin(clock)
    frame.to_csv(tmp_path / "first.csv", index=False)
    frame.drop(columns=["effort_shoulder", "effort_elbow"]).to_csv(tmp_path / "second.csv", index=False)
    refused(tmp_path, [tmp_path / "first.csv", tmp_path / "second.csv"], "holds no effort")


def test_commands_that_one_bag_lacks_are_told_of_it_and_of_no_file_that_is_not_there(
    tmp_path: Path, write_bag: Callable[..., Path]
) -> None:
    bags = [write_bag(tmp_path / "first", "mcap", messages())]
    bags.append(write_bag(tmp_path / "second", "mcap", [m for m in messages() if m[0] == "/joint_states"]))
    refused(tmp_path, bags, "has no topic /joint_commands")


def refused(folder: Path, recordings: list[Path], sentence: str) -> None:
    """The second recording is refused as it lacks something of the first, and what to do is told."""
    with pytest.raises(
        InputError, match=rf"^\S*second\S*: does not fit .*first.*{sentence}.*leave this one out"
    ) as told:
        init(arm(folder / "arm.urdf"), recordings, folder / "out")
    assert "scenario.yaml" not in str(told.value)
    assert not (folder / "out").exists()
