"""A folder of several recordings is that of as many runs, and what it holds beside them is told."""

import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from first_scenario import arm, goal, messages
from realitygap.files.errors import InputError
from realitygap.init.draft import Draft, init
from realitygap.scenario.file import load_scenario

CLOCK = np.arange(100) * 0.01


def drafted(folder: Path, *given: Path) -> tuple[Draft, list[Path]]:
    """The first scenario of recordings, and where those of its runs lie."""
    draft = init(arm(folder / "arm.urdf"), list(given), folder / "out")
    return draft, [case.path.resolve() for case in load_scenario(draft.path).cases()]


def table(path: Path, late: float = 0.0) -> Path:
    frame = pd.DataFrame({"time": CLOCK})
    for joint in ("shoulder", "elbow"):
        frame[f"{joint}_pos"], frame[f"{joint}_goal"] = goal(CLOCK - late), goal(CLOCK)
    frame.to_csv(path, index=False)
    return path


@pytest.mark.parametrize("form", ["bag", "mcap", "db3", "mcap alone"])
def test_every_bag_is_a_run(form: str, tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    day = tmp_path / "day"
    day.mkdir()
    kind, _, alone = form.partition(" ")
    for k in (1, 2, 3):
        path = write_bag(day / (f"run{k}.bag" if kind == "bag" else f"run{k}"), kind, messages(lag=0.01 * k))
        if alone:
            next(path.glob("*.mcap")).rename(day / f"run{k}.mcap")
            shutil.rmtree(path)
    table(day / "notes.csv")
    (day / "readme.txt").write_text("of Monday")
    draft, paths = drafted(tmp_path, day)
    names = [path.name for path in sorted(day.glob("run*"))]
    assert paths == [(day / name).resolve() for name in names]
    assert draft.told[0] == (
        f"{day} holds 3 recordings, of which each is a run: {', '.join(names)}; not used of it: notes.csv"
    )


def test_of_a_folder_without_bags_every_table_is(tmp_path: Path) -> None:
    (tmp_path / "day").mkdir()
    for k in (1, 2):
        table(tmp_path / "day" / f"run{k}.csv", late=0.01 * k)
    _, paths = drafted(tmp_path, tmp_path / "day", table(tmp_path / "more.csv"))
    assert [path.name for path in paths] == ["run1.csv", "run2.csv", "more.csv"]


def test_the_folder_of_one_bag_is_that_bag(tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    bag = write_bag(tmp_path / "run", "mcap", messages())
    shutil.copytree(bag, tmp_path / "killed")
    (tmp_path / "killed" / "metadata.yaml").unlink()
    draft, paths = drafted(tmp_path, bag)
    assert paths == [bag.resolve()]
    assert not any("holds" in line for line in draft.told)
    shutil.rmtree(tmp_path / "out")
    assert drafted(tmp_path, tmp_path / "killed")[1] == [(tmp_path / "killed").resolve()]


def test_a_folder_without_recordings_is_refused(tmp_path: Path) -> None:
    (tmp_path / "day").mkdir()
    (tmp_path / "day" / "notes.txt").write_text("none")
    with pytest.raises(InputError, match=r"day: is a folder without metadata.yaml and with no .mcap, .db3 or .bag"):
        drafted(tmp_path, tmp_path / "day")
