"""A first scenario of bags in which several publishers tell the states of a robot on one topic."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from first_scenario import arm, messages, read_all
from realitygap.init.draft import init
from signals import there

ALONE = (("gripper",), ("elbow", "shoulder"))
EACH = (("gripper",), ("shoulder",), ("elbow",))


def apart(groups: tuple[tuple[str, ...], ...], prefix: str = "") -> list[tuple[str, float, str, dict[str, Any]]]:
    """The messages of a robot, with those of its states split by joint, each group a little later."""
    out = []
    for topic, at, kind, fields in messages():
        if topic != "/joint_states":
            out.append((topic, at, kind, {**fields, "name": [prefix + n for n in fields["name"]]}))
            continue
        names = list(fields["name"])
        for i, group in enumerate(groups):
            own = [names.index(name) for name in group]
            part = {signal: [fields[signal][k] for k in own] for signal in ("position", "velocity")}
            stamp = {"stamp": fields["stamp"], "name": [prefix + names[k] for k in own]}
            out.append((topic, at + 1e-4 * i, kind, {**stamp, **part}))
    return out


@pytest.mark.parametrize("groups", [ALONE, EACH])
@pytest.mark.parametrize("form", ["bag", "mcap"])
def test_every_joint_that_some_message_names_is_measured(
    groups: tuple[tuple[str, ...], ...], form: str, tmp_path: Path, write_bag: Callable[..., Path]
) -> None:
    whole = write_bag(tmp_path / ("whole.bag" if form == "bag" else "whole"), form, messages())
    split = write_bag(tmp_path / ("split.bag" if form == "bag" else "split"), form, apart(groups))
    urdf = arm(tmp_path / "arm.urdf")
    scenario, (found,) = read_all(init(urdf, [split], tmp_path / "out").path, ["shoulder", "elbow"])
    _, (expected,) = read_all(init(urdf, [whole], tmp_path / "all").path, ["shoulder", "elbow"])
    assert there(scenario.recordings).state == "/joint_states"
    assert there(scenario.motion).recorded == "/joint_commands"
    assert not scenario.robot.hold
    np.testing.assert_array_equal(there(found.trace.position), there(expected.trace.position))


def test_names_with_something_before_them_are_gathered_from_all_messages(
    tmp_path: Path, write_bag: Callable[..., Path]
) -> None:
    split = write_bag(tmp_path / "split", "mcap", apart(EACH, "left_"))
    path = init(arm(tmp_path / "arm.urdf"), [split], tmp_path / "out").path
    assert 'joints: {"*": "left_*"}' in path.read_text()
    _, (found,) = read_all(path, ["shoulder", "elbow"])
    assert len(found.trace.time) == 300


def test_a_joint_that_no_message_names_is_held(tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    bag = write_bag(tmp_path / "run", "mcap", apart((("gripper",), ("elbow",))))
    draft = init(arm(tmp_path / "arm.urdf"), [bag], tmp_path / "out")
    assert 'hold: {"shoulder": 0}' in draft.path.read_text()
