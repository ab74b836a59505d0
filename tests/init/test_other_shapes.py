"""Tables that hold joints in another way than in columns are refused with what they are and what to do."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from first_scenario import arm, goal
from realitygap.files.errors import InputError
from realitygap.init.draft import init

CLOCK = np.arange(100) * 0.01
JOINTS = ("shoulder", "elbow")


def refused(folder: Path, frame: pd.DataFrame, suffix: str = ".csv") -> str:
    path = folder / f"run{suffix}"
    frame.to_parquet(path) if suffix == ".parquet" else frame.to_csv(path, index=False)
    with pytest.raises(InputError) as told:
        init(arm(folder / "arm.urdf"), [path], folder / "out")
    return str(told.value)


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_a_row_for_every_joint(suffix: str, tmp_path: Path) -> None:
    """And what is said to do about it does it."""
    rows = pd.DataFrame({"time": np.repeat(CLOCK, 2), "joint": JOINTS * 100, "position": np.repeat(goal(CLOCK), 2)})
    rows["command"] = rows["position"]
    said = refused(tmp_path, rows, suffix)
    assert "; joint names the joints, row by row: make a column of each joint's signals" in said
    assert "frame.pivot(index='time', columns='joint')" in said
    wide = rows.pivot(index="time", columns="joint")
    wide.columns = wide.columns.map("_".join)
    wide.reset_index().to_csv(tmp_path / "wide.csv", index=False)
    init(tmp_path / "arm.urdf", [tmp_path / "wide.csv"], tmp_path / "out")


@pytest.mark.parametrize("form", ["[{}, {}]", "({}; {})", "{} {}", "list"])
def test_lists_in_cells(form: str, tmp_path: Path) -> None:
    values = [[q, 2 * q] if form == "list" else form.format(q, 2 * q) for q in goal(CLOCK)]
    said = refused(tmp_path, pd.DataFrame({"time": CLOCK, "position": values}), ".parquet")
    assert said.endswith("; position holds several numbers in every cell: make a column of each, as position_shoulder")


def test_values_without_names(tmp_path: Path) -> None:
    """As `ros2 topic echo --csv` writes joint states, names among them."""
    rows = [f"1700000000,{int(1e9 * t)},,shoulder,elbow,{goal(t)},{goal(t)},0.0,0.0,0.0,0.0\n" for t in CLOCK]
    (tmp_path / "run.csv").write_text("".join(rows))
    with pytest.raises(InputError, match="begins with numbers; expected a line with the names of the columns above"):
        init(arm(tmp_path / "arm.urdf"), [tmp_path / "run.csv"], tmp_path / "out")
