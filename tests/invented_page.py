"""A result folder of three invented engines whose errors are known, as the page shows it."""

from pathlib import Path

import numpy as np
import synthetic
from realitygap.compare.row import Cell
from realitygap.report import write_page

JOINTS = ("hip", "knee", "ankle", "toe")
ERRORS = {"mujoco": 0.01, "dart": 0.02, "drake": 0.0101}
CELL = 'document.querySelector(\'td[data-r="{}"][data-c="{}"]\')'
DETAIL = "document.getElementById('detail').textContent"


def error(one: Cell) -> float:
    if one.engine == "dart" and one.step_rate == 500:
        return np.inf
    return ERRORS[one.engine] * (2 if one.robot_revision == "old" else 1) * (1.5 if one.step_rate == 500 else 1)


def write(folder: Path) -> Path:
    """The page of all cells in `folder`."""
    cells = synthetic.grid(
        engine=["mujoco", "dart", "drake"],
        robot_revision=["old", "new"],
        step_rate=[500.0, 1000.0],
        recording=["kick", "squat"],
    )
    synthetic.write_folder(folder, joints=JOINTS, cells=cells, error=error)
    return write_page(folder)
