"""Keyframe animations: goals in degrees at the right times, joints that are left out hold."""

import json
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from realitygap.files.errors import InputError
from realitygap.simulate.motion import Animation, first_goals, play, read_animation
from realitygap_engines.model.robot import Joint, Link, Model

JOINTS = ("knee", "hip", "neck")
LINKS = tuple(Link(f"l{i}", 1.0, np.zeros(3), np.eye(3)) for i in range(4))
MODEL = Model(
    "m", LINKS, tuple(Joint(n, False, i, np.eye(4), np.eye(3)[2], -1.0, 1.0) for i, n in enumerate(JOINTS)), False
)


def animation(folder: Path, *keyframes: dict[str, object], **more: object) -> tuple[Path, Animation]:
    path = folder / "move.json"
    path.write_text(json.dumps({"keyframes": keyframes, **more}))
    return path, read_animation(path)


def test_goals_are_reached_at_their_times_and_held_in_pauses(tmp_path: Path) -> None:
    """Keys of other players (author, torque) are no concern of this one."""
    path, moves = animation(
        tmp_path,
        {"goals": {"knee": 30.0, "hip": -10.0}, "duration": 0.5, "pause": 0.2, "torque": {"knee": 1}},
        {"goals": {"knee": 0.0}, "duration": 1.0},
        author="somebody",
    )
    start = np.array([0.1, 0.2, 0.3])
    commands, length = play(path, moves, MODEL, start)
    assert length == pytest.approx(1.7)
    assert not commands.held
    at = {
        t: [float(np.interp(t, commands.time, column)) for column in commands.value.T]
        for t in (0, 0.25, 0.5, 0.7, 1.2, 1.7)
    }
    knee, hip = np.deg2rad([30.0, -10.0])
    assert_allclose(at[0], start)
    assert_allclose(at[0.25], [(0.1 + knee) / 2, (0.2 + hip) / 2, 0.3])
    assert_allclose(at[0.5], [knee, hip, 0.3])
    assert_allclose(at[0.7], [knee, hip, 0.3])
    assert_allclose(at[1.2], [knee / 2, hip, 0.3])
    assert_allclose(at[1.7], [0.0, hip, 0.3])


def test_a_keyframe_without_duration_still_takes_a_tick(tmp_path: Path) -> None:
    path, moves = animation(tmp_path, {"goals": {"knee": 10.0}, "duration": 0})
    commands, length = play(path, moves, MODEL, np.zeros(3))
    assert length > 0
    assert (np.diff(commands.time) > 0).all()


def test_the_first_goals_are_a_start(tmp_path: Path) -> None:
    path, moves = animation(tmp_path, {"goals": {"neck": 20.0}, "duration": 1}, {"goals": {"knee": 5.0}, "duration": 1})
    assert_allclose(first_goals(path, moves, MODEL), [0, 0, np.deg2rad(20)])


@pytest.mark.parametrize(
    ("goals", "sentence"),
    [
        ({"elbow": 1.0}, "keyframe 'lift' moves elbow; the robot has knee, hip, neck"),
        ({"knee": 60.0}, "puts knee at 60°, outside its limits -57.3° to 57.3°"),
        ({"knee": -60.0}, "outside its limits"),
    ],
)
def test_goals_that_the_robot_cannot_reach(goals: dict[str, float], sentence: str, tmp_path: Path) -> None:
    path, moves = animation(tmp_path, {"name": "lift", "goals": goals, "duration": 1})
    with pytest.raises(InputError, match=sentence):
        play(path, moves, MODEL, np.zeros(3))


def test_a_goal_may_be_a_little_outside(tmp_path: Path) -> None:
    """As it is where a URDF's limits are rounded; the servo is told what the animation says."""
    path, moves = animation(tmp_path, {"goals": {"knee": 58.5}, "duration": 1})
    commands, _ = play(path, moves, MODEL, np.zeros(3))
    assert commands.value[-1, 0] == np.deg2rad(58.5)
