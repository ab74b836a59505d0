"""Tables as spreadsheets write them: decimal commas, points between thousands, and cells that hold no reading."""

from pathlib import Path

import bags
import numpy as np
import pandas as pd
import pytest
from bags import FILE
from first_scenario import arm, goal, read_all
from realitygap.files.errors import InputError
from realitygap.init.draft import init
from realitygap.recording import read_recording
from realitygap.recording.recording import Recording
from signals import Signals, there

CLOCK = np.arange(200) * 0.01
JOINTS = ("shoulder", "elbow")
MOTION = {"shoulder": goal(CLOCK), "elbow": 1500.0 + 900.0 * goal(CLOCK)}


def german(value: float, points: bool = True) -> str:
    text = f"{value:,.3f}".replace(",", "_").replace(".", ",")
    return text.replace("_", "." if points else "")


def cells(points: bool = True) -> pd.DataFrame:
    """Of a slow motion in mm and of its time in ms, which pass a thousand, and of one whose first second is whole."""
    frame = pd.DataFrame({"time": [german(1e3 * t, points) for t in CLOCK]})
    for joint, value in MOTION.items():
        frame[f"position_{joint}"] = [german(v, points) for v in value]
    frame["effort_shoulder"], frame["effort_elbow"] = ["0" if t < 1.0 else "0,5" for t in CLOCK], "1.000"
    return frame


def read(frame: pd.DataFrame, folder: Path) -> Recording:
    frame.to_csv(folder / "run.csv", index=False, sep=";")
    asked = bags.scenario(None, None, effort="motor", columns={"units": {"time": "ms"}})
    return read_recording(folder / "run.csv", asked, JOINTS, file=FILE)


@pytest.mark.parametrize("points", [True, False])
def test_points_are_those_of_thousands_where_a_cell_says_so(points: bool, tmp_path: Path) -> None:
    recording = read(cells(points), tmp_path)
    np.testing.assert_allclose(recording.trace.time, CLOCK, atol=1e-9)
    np.testing.assert_allclose(Signals(recording.trace).position, np.column_stack([*MOTION.values()]), atol=6e-4)
    effort = there(recording.trace.effort)
    np.testing.assert_array_equal(effort[:, 0], np.where(CLOCK < 1.0, 0.0, 0.5))
    assert (effort[:, 1] == (1000.0 if points else 1.0)).all()
    assert any("stand for thousands" in note for note in recording.notes) == points


def test_a_point_that_is_none_of_thousands_beside_those_is_refused(tmp_path: Path) -> None:
    frame = cells()
    frame.loc[7, "position_shoulder"] = "0.25"
    with pytest.raises(InputError, match=r"position_shoulder is '0.25' in line 9, expected a number"):
        read(frame, tmp_path)


@pytest.mark.parametrize("word", ["-", "#NV", "n/a", "NaN", "k.A.", "#DIV/0!", ""])
def test_a_cell_that_says_that_nothing_is_there_holds_no_reading(word: str, tmp_path: Path) -> None:
    frame = cells()
    frame.loc[[3, 4, 90], "position_elbow"] = word
    recording = read(frame, tmp_path)
    assert "3 of 200 samples are left out, as they are without the position of elbow (3)" in recording.notes
    kept = np.delete(MOTION["elbow"], [3, 4, 90])
    np.testing.assert_allclose(Signals(recording.trace).position[:, 1], kept, atol=6e-4)


def test_a_first_scenario_takes_such_a_table(tmp_path: Path) -> None:
    frame = cells().rename(columns={"time": "Zeit [ms]", "position_elbow": "elbow Ist [mm]"})
    frame = frame.rename(columns={"position_shoulder": "shoulder Ist [rad]"}).drop(columns="effort_elbow")
    frame["shoulder Soll"] = frame["elbow Soll"] = "-"
    frame.loc[0, ["shoulder Soll", "elbow Soll"]] = "0,1"
    frame.to_csv(tmp_path / "run.csv", index=False, sep=";", encoding="latin-1")
    _, (recording,) = read_all(init(arm(tmp_path / "arm.urdf"), [tmp_path / "run.csv"], tmp_path / "out").path, JOINTS)
    np.testing.assert_allclose(recording.trace.time, CLOCK, atol=1e-9)
    np.testing.assert_allclose(Signals(recording.trace).position[:, 1], 1e-3 * MOTION["elbow"], atol=1e-6)
