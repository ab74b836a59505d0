"""What a check says to do about the velocity of a bag's state can be written into the scenario as it stands."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from first_scenario import EPOCH, STATE, arm, goal
from realitygap.check import check
from realitygap.scenario.file import load_scenario

JOINTS = ["shoulder", "elbow"]
FIELDS = {"topic": "/robot/joints", "names": "name", "position": "position", "velocity": "velocity"}


@pytest.mark.parametrize("state", ["/robot/joints", FIELDS])
def test_the_advice_leaves_out_a_velocity_that_never_changes(
    state: str | dict[str, Any], tmp_path: Path, write_bag: Callable[..., Path]
) -> None:
    told = []
    for t in np.arange(0.0, 4.0, 0.01):
        measured = {"stamp": EPOCH + t, "name": JOINTS, "position": [goal(t), 0.5 * goal(t)], "velocity": [0.1, 0.1]}
        told.append(("/robot/joints", EPOCH + t, STATE, measured))
    arm(tmp_path / "arm.urdf")
    content: dict[str, Any] = {
        "name": "arm",
        "robot": {"urdf": "arm.urdf", "base": "fixed"},
        "servos": [{"joints": "*", "kind": "effort"}],
        "recordings": {"state": state, "runs": [{"path": str(write_bag(tmp_path / "run", "mcap", told))}]},
    }
    (tmp_path / "scenario.yaml").write_text(yaml.safe_dump(content))
    found = [m for m in check(load_scenario(tmp_path / "scenario.yaml")) if m.kind == "velocity"]
    assert {m.joints for m in found} == {("shoulder",), ("elbow",)}
    advice = found[0].sentence.rpartition("or none: ")[2].removesuffix(" leaves it out")
    if isinstance(state, str):
        written = re.fullmatch(r"recordings\.state: (\{.*\})", advice)
        assert written is not None
        content["recordings"]["state"] = yaml.safe_load(written[1])
    else:
        assert advice == "recordings.state without `velocity`"
        content["recordings"]["state"] = {key: field for key, field in FIELDS.items() if key != "velocity"}
    (tmp_path / "scenario.yaml").write_text(yaml.safe_dump(content))
    assert [m for m in check(load_scenario(tmp_path / "scenario.yaml")) if m.kind == "velocity"] == []
