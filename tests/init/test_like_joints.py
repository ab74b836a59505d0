"""Messages that have fields called as those of joint states, and hold other things in them, break nothing."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bags import FILE, scenario
from first_scenario import EPOCH, arm, goal, messages, read_all
from realitygap.files.errors import InputError
from realitygap.init.draft import init
from realitygap.recording import read_recording
from signals import Signals

HEADER = "std_msgs/Header header\n"
LIKE: dict[str, tuple[str, dict[str, Any]]] = {
    "of one joint": ("string name\nfloat64 goal_pos\nfloat64 current_pos\nfloat64 velocity\n", {"name": "elbow"}),
    "of a body": ("string name\ngeometry_msgs/Vector3 velocity\n", {"name": "elbow"}),
    "of bodies": ("string[] name\ngeometry_msgs/Vector3[] position\n", {"name": ["elbow"], "position": [{"x": 1.0}]}),
    "by number": ("int32 name\nfloat64[] position\n", {"name": 3, "position": [1.0]}),
    "of text": ("string[] name\nstring[] position\n", {"name": ["elbow"], "position": ["up"]}),
}


@pytest.mark.parametrize("kind", LIKE)
@pytest.mark.parametrize("form", ["bag", "mcap"])
def test_the_joint_states_beside_them_are_read(
    form: str, kind: str, tmp_path: Path, write_bag: Callable[..., Path]
) -> None:
    definition, value = LIKE[kind]
    other = [
        ("/other", EPOCH + 0.01 * k, "lab_msgs/msg/State", {"stamp": EPOCH + 0.01 * k, **value}) for k in range(300)
    ]
    types = {"lab_msgs/msg/State": HEADER + definition}
    told = sorted([*messages(velocity=False), *other], key=lambda m: m[1])
    path = write_bag(tmp_path / ("run.bag" if form == "bag" else "run"), form, told, types)
    draft = init(arm(tmp_path / "arm.urdf"), [path], tmp_path / "out")
    _, (recording,) = read_all(draft.path, ["shoulder", "elbow"])
    np.testing.assert_allclose(Signals(recording.trace).position[:, 1], goal(recording.trace.time - 0.05), atol=1e-6)
    assert any("/other (lab_msgs/State)" in line for line in draft.told)


@pytest.mark.parametrize("kind", ["of a body", "of bodies", "of text"])
def test_a_field_that_holds_no_numbers_is_told_where_a_scenario_names_it(
    kind: str, tmp_path: Path, write_bag: Callable[..., Path]
) -> None:
    definition, value = LIKE[kind]
    field = "velocity" if kind == "of a body" else "position"
    told = [("/other", EPOCH + 0.01 * k, "lab_msgs/msg/State", {"stamp": EPOCH + 0.01 * k, **value}) for k in range(9)]
    path = write_bag(tmp_path / "run", "mcap", told, {"lab_msgs/msg/State": HEADER + definition})
    asked = scenario({"topic": "/other", "names": "name", "position": field}, None)
    with pytest.raises(InputError, match=rf"/other: message 1: holds no array of numbers in {field}; expected fields"):
        read_recording(path, asked, ["elbow"], file=FILE)
