"""Which columns of a table a first scenario takes for what, where one word of a name is not all that it says."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from first_scenario import arm, goal, read_all
from realitygap.init.draft import Draft, init
from realitygap.init.names import role_of, words
from signals import Signals, there

CLOCK = np.arange(100) * 0.01
JOINTS = ("shoulder", "elbow")


def drafted(folder: Path, frame: pd.DataFrame, joints: tuple[str, ...] = JOINTS) -> Draft:
    """The first scenario of one table."""
    frame.to_csv(folder / "run.csv", index=False)
    return init(arm(folder / "arm.urdf", joints), [folder / "run.csv"], folder / "out")


@pytest.mark.parametrize("joints", [("elbow",), JOINTS])
@pytest.mark.parametrize("name", ["torque_enabled", "torque_enable"])
def test_a_flag_of_the_torque_is_no_torque(name: str, joints: tuple[str, ...], tmp_path: Path) -> None:
    on = (CLOCK > 0.3).astype(int)
    frame = pd.DataFrame({"time": CLOCK})
    for joint in joints:
        end = f"_{joint}" if len(joints) > 1 else ""
        frame[f"command{end}"], frame[f"position{end}"], frame[f"{name}{end}"] = goal(CLOCK), goal(CLOCK), on
    draft = drafted(tmp_path, frame, joints)
    scenario, (recording,) = read_all(draft.path, joints)
    recordings = there(scenario.recordings)
    assert (recordings.effort, recordings.columns.torque_enabled) == ("none", name)
    assert recording.trace.effort is None
    np.testing.assert_array_equal(np.isnan(Signals(recording.trace).command[:, 0]), on == 0)
    assert not any(line.startswith("not used") for line in draft.told)


@pytest.mark.parametrize("label", ["torque_limit", "position_limit", "torque_mode"])
def test_what_bounds_a_signal_is_none(label: str) -> None:
    assert role_of(words(label)) is None
