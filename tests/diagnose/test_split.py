"""Which motions are kept back, on the bundled demo (synthetic)."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from realitygap.compare.comparison import motions_of
from realitygap.diagnose.data.case import cases_of
from realitygap.diagnose.data.split import split
from realitygap.scenario.file import load_scenario

DEMO = Path(__file__).parents[2] / "scenarios" / "demo" / "scenario.yaml"


def test_a_single_run_is_cut_and_loses_nothing() -> None:
    file = load_scenario(DEMO)
    motion = motions_of(file)[0]
    (whole,) = cases_of([motion])
    (first, rest), said = split(file, [replace(whole, use="")], [motion])
    assert (first.use, rest.use) == ("train", "held_out")
    assert "there is one run" in said
    time = whole.measured.time
    assert first.measured.time[-1] - time[0] == pytest.approx(0.6 * (time[-1] - time[0]), abs=2.0 * np.diff(time).max())
    assert np.array_equal(np.concatenate([first.measured.time, rest.measured.time]), whole.measured.time)


def test_without_a_mark_every_third_motion_is_kept_back() -> None:
    file = load_scenario(DEMO)
    motions = motions_of(file)
    marked, said = split(file, [replace(c, use="") for c in cases_of(motions)], motions)
    assert [c.use for c in marked] == ["held_out" if i % 3 == 2 else "train" for i in range(len(marked))]
    assert "every third motion was kept back" in said
