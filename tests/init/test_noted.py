"""What a first scenario notes of the recordings it is made of."""

from pathlib import Path

import numpy as np
import pandas as pd
from first_scenario import arm, goal
from realitygap.init.draft import init


def test_rows_that_came_in_no_order_are_told(tmp_path: Path) -> None:
    clock = np.arange(100) * 0.01
    frame = pd.DataFrame({"time": clock, "position": goal(clock), "command": goal(clock)})
    frame = frame.sample(frac=1.0, random_state=1)
    frame.to_csv(tmp_path / "run.csv", index=False)
    draft = init(arm(tmp_path / "arm.urdf", ["elbow"]), [tmp_path / "run.csv"], tmp_path / "out")
    back = (frame["time"].diff() < 0).sum()
    assert draft.told[-1] == f"run: {back} rows came out of order and were sorted"
