"""Names come from anybody: a spreadsheet computes none of them, and each comes back from the file as it was."""

import csv
from pathlib import Path

import pytest
from realitygap.compare.row import Row
from realitygap.compare.table import read_gaps, table, to_csv

FORMULAS = ("=1+1", "+a", "-a", "@a", "\ta", "'=a", "''+a", '=HYPERLINK("a";"b")')
WORDS = ("elbow", "'a", "a=b", "left knee", "a,b")


def row(joint: str) -> Row:
    words = dict.fromkeys(("robot_revision", "engine_version", "ground", "recorded_ground", "use", "overrides"), "")
    numbers = dict.fromkeys(("mean_abs", "median_abs", "p95_abs", "max_abs", "noise_floor", "numerical_floor"), -1.0)
    cell = {"scenario": joint, "engine": "mujoco", "recording": "r", "step_rate": 1000.0, "solver_iterations": None}
    rest = {"joint": joint, "group": "moving", "signal": "position", "unit": "deg", "outcome": "ok", "note": ""}
    return Row(**words | numbers | cell | rest)  # type: ignore[arg-type]


@pytest.mark.parametrize("name", FORMULAS + WORDS)
def test_a_name_is_no_formula_and_comes_back(name: str, tmp_path: Path) -> None:
    path = tmp_path / "gaps.csv"
    path.write_text(to_csv(table([row(name)])), encoding="utf-8")
    (cells,) = csv.DictReader(path.read_text(encoding="utf-8").splitlines())
    assert not cells["joint"].startswith(("=", "+", "-", "@", "\t"))
    assert cells["joint"].startswith("'") or name in WORDS
    assert list(read_gaps(path)["joint"]) == list(read_gaps(path)["scenario"]) == [name]
