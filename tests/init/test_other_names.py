"""A first scenario of a bag with other names for the joints, as `left_arm/elbow`."""

from collections.abc import Callable, Sequence
from pathlib import Path

import pytest
from first_scenario import arm, messages, read_all
from realitygap.files.errors import InputError
from realitygap.init.draft import init
from signals import Signals, there


@pytest.mark.parametrize("names", [("left_arm/elbow", "left_arm/shoulder"), ("r1_elbow", "r1_gripper", "r1_shoulder")])
def test_a_prefix_of_all_joints_is_found_and_said(
    names: Sequence[str], tmp_path: Path, write_bag: Callable[..., Path]
) -> None:
    bag = write_bag(tmp_path / "run", "mcap", messages(names=names))
    draft = init(arm(tmp_path / "arm.urdf"), [bag], tmp_path / "out")
    scenario, (recording,) = read_all(draft.path, ["shoulder", "elbow"])
    pattern = names[0].replace("elbow", "*")
    assert there(scenario.recordings).joints == {"*": pattern}
    assert (there(scenario.recordings).state, there(scenario.motion).recorded) == ("/joint_states", "/joint_commands")
    assert not scenario.robot.hold
    assert Signals(recording.trace).command.any()
    assert f'guessed: joints: {{"*": "{pattern}"}} (so the recording names the joints)' in draft.lines()


@pytest.mark.parametrize("names", [("Shoulder", "Elbow"), ("SHOULDER_", "el-bow")])
def test_names_that_are_spelt_otherwise_are_found_and_said(
    names: Sequence[str], tmp_path: Path, write_bag: Callable[..., Path]
) -> None:
    bag = write_bag(tmp_path / "run", "mcap", messages(names=names))
    draft = init(arm(tmp_path / "arm.urdf"), [bag], tmp_path / "out")
    scenario, (recording,) = read_all(draft.path, ["shoulder", "elbow"])
    assert there(scenario.recordings).joints == {"shoulder": names[0], "elbow": names[1]}
    assert there(scenario.motion).recorded == "/joint_commands"
    assert Signals(recording.trace).command.any()
    said = f'guessed: joints: {{"shoulder": "{names[0]}", "elbow": "{names[1]}"}} (so the recording names the joints)'
    assert said in draft.lines()


@pytest.mark.parametrize("names", [("Shoulder", "Elbow", "ELBOW"), ("Shoulder", "wrist")])
def test_names_that_are_not_all_told_apart_are_left_to_the_user(
    names: Sequence[str], tmp_path: Path, write_bag: Callable[..., Path]
) -> None:
    bag = write_bag(tmp_path / "run", "mcap", messages(names=names))
    with pytest.raises(InputError, match=r"recordings\.joints tells their names"):
        init(arm(tmp_path / "arm.urdf"), [bag], tmp_path / "out")


def test_of_two_arms_the_other_is_said(tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    names = [f"{side}/{joint}" for side in ("left", "right") for joint in ("shoulder", "elbow")]
    bag = write_bag(tmp_path / "run", "mcap", messages(names=names))
    draft = init(arm(tmp_path / "arm.urdf"), [bag], tmp_path / "out")
    assert any(line.startswith('joints: {"*": "left/*"}') and "also right/*" in line for line in draft.guessed)


def test_names_that_nothing_tells_are_left_to_the_user(tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    bag = write_bag(tmp_path / "run", "mcap", messages(names=("j1", "j2")))
    with pytest.raises(
        InputError, match=r"names j1, j2; .*or write a scenario whose recordings.joints tells their names"
    ):
        init(arm(tmp_path / "arm.urdf"), [bag], tmp_path / "out")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("prefix", ["left_", "j_"])
def test_commands_that_have_other_names_than_the_states_are_told(
    prefix: str, tmp_path: Path, write_bag: Callable[..., Path]
) -> None:
    own = [f"{prefix}{joint}" for joint in ("shoulder", "elbow")]
    states = [m for m in messages(names=own) if m[0] == "/joint_states"]
    commands = [m for m in messages(names=("shoulder", "elbow")) if m[0] == "/joint_commands"]
    bag = write_bag(tmp_path / "run", "mcap", sorted([*states, *commands], key=lambda m: m[1]))
    urdf = arm(tmp_path / "arm.urdf", ("shoulder", "elbow") if prefix == "j_" else own)
    said = [line for line in init(urdf, [bag], tmp_path / "out").told if line.startswith("/joint_commands")]
    assert said == [
        "/joint_commands was left out because of the joints that it names: elbow, shoulder; expected "
        f"{prefix}shoulder, {prefix}elbow, as in the state"
    ]
