"""Tables that `rostopic echo -p` writes of joint states: joints are named by the values of columns, row by row."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from first_scenario import arm, goal, read_all
from realitygap.init.draft import init
from signals import Signals

JOINTS = ("shoulder", "elbow")
CLOCK = np.arange(100) * 0.01
MOTION = {"position": goal(CLOCK), "velocity": np.cos(CLOCK), "effort": np.sin(CLOCK)}


def echoed(folder: Path, form: str = "field.{}{}", time: str = "%time", swapped: int = 0) -> Path:
    """As the tool writes it, with time in ns; the first `swapped` rows name the joints the other way."""
    stamp = 1_700_000_000_990_000_000 + (CLOCK * 1e9).round().astype(np.int64)
    frame = pd.DataFrame({time: stamp, "field.header.seq": range(100), "field.header.stamp": stamp - 1000})
    frame["field.header.frame_id"] = ""
    first = np.arange(100) < swapped
    order = [np.where(first, 1 - k, k) for k in (0, 1)]
    for k in (0, 1):
        frame[form.format("name", k)] = np.array(JOINTS)[order[k]]
    for signal, value in MOTION.items():
        for k in (0, 1):
            frame[form.format(signal, k)] = value + order[k]
    frame.to_csv(folder / "run.csv", index=False)
    return folder / "run.csv"


@pytest.mark.parametrize("swapped", [0, 30])
@pytest.mark.parametrize("form", ["field.{}{}", "{}_{}", "{}[{}]"])
def test_joints_are_those_that_the_rows_name(form: str, swapped: int, tmp_path: Path) -> None:
    time = "%time" if form.startswith("field") else "time"
    table = echoed(tmp_path, form, time, swapped)
    draft = init(arm(tmp_path / "arm.urdf", JOINTS[::-1]), [table], tmp_path / "out")
    _, (recording,) = read_all(draft.path, JOINTS)
    np.testing.assert_allclose(recording.trace.time, CLOCK, atol=1e-6)
    for signal, value in MOTION.items():
        np.testing.assert_allclose(getattr(Signals(recording.trace), signal), np.column_stack([value, value + 1]))
    assert any("counts in ns" in line for line in draft.guessed)


def test_a_comment_above_a_header_is_no_header(tmp_path: Path) -> None:
    """Though it has as many words, and the row below it text, too."""
    frame = pd.DataFrame({"time": CLOCK, "mode": "free"} | {f"position_{j}": goal(CLOCK) for j in JOINTS})
    (tmp_path / "run.csv").write_text(f"# robot, lab, anna, 2024\n{frame.to_csv(index=False)}")
    _, (recording,) = read_all(init(arm(tmp_path / "arm.urdf"), [tmp_path / "run.csv"], tmp_path / "o").path, JOINTS)
    np.testing.assert_allclose(Signals(recording.trace).position[:, 0], goal(CLOCK))


def test_the_arrays_of_a_controllers_state_are_of_its_joints(tmp_path: Path) -> None:
    """Other arrays are none of joints, as they have other numbers of elements."""
    frame = pd.DataFrame({"%time": 1_700_000_000_990_000_000 + (CLOCK * 1e9).round().astype(np.int64)})
    for k, joint in enumerate(JOINTS):
        frame[f"field.joint_names{k}"] = joint
    for part, late in (("desired", 0.0), ("actual", 0.05)):
        for k in (0, 1):
            frame[f"field.{part}.positions{k}"] = goal(CLOCK - late) + k
    for k in range(3):
        frame[f"field.gains{k}"] = 1.0
    frame.to_csv(tmp_path / "run.csv", index=False)
    draft = init(arm(tmp_path / "arm.urdf", JOINTS[::-1]), [tmp_path / "run.csv"], tmp_path / "out")
    _, (recording,) = read_all(draft.path, JOINTS)
    for value, late in ((recording.command, 0.0), (Signals(recording.trace).position, 0.05)):
        np.testing.assert_allclose(value, np.column_stack([goal(CLOCK - late), goal(CLOCK - late) + 1]))
    assert draft.told[0] == "not used: field.gains0, field.gains1, field.gains2"
