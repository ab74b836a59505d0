"""A joint that nobody drives, on purpose: no mistake, and physics may be named there."""

import sys
from pathlib import Path

import numpy as np
import pytest
from realitygap.check import check
from realitygap.robot.effects import EFFECTS
from realitygap.robot.plant import build_plant
from realitygap.scenario.file import load_scenario

sys.path.insert(0, str(Path(__file__).parent))  # plain modules, not a package

from spoil import without_servo
from teams import Team, demo


@pytest.fixture(scope="module")
def team() -> Team:
    """The demo whose elbow has no servo."""
    out = demo()
    without_servo(out, 1)
    return out


@pytest.mark.parametrize("told", [None, 0.0, "moves"])
def test_a_joint_without_a_servo_is_a_mistake_where_it_is_told_to_move(
    told: float | str | None, team: Team, tmp_path: Path
) -> None:
    passive = team.copy()
    for table in passive.tables.values():
        if told != "moves":
            table.command[:, 1] = np.nan if told is None else told
    found = [m.kind for m in check(load_scenario(passive.write(tmp_path)))]
    assert ("undriven_joint" in found) == (told == "moves")


def test_servos_that_are_off_all_along_are_told_with_what_accepts_them(team: Team, tmp_path: Path) -> None:
    off = team.copy()
    for table in off.tables.values():
        table.command[:] = np.nan
    (found,) = [m for m in check(load_scenario(off.write(tmp_path))) if m.kind == "drives_nothing"]
    assert "no command of a joint whose servo is on" in found.sentence
    assert "`accept: [drives_nothing]`" in found.sentence


def test_what_is_tried_there_does_not_hang_on_the_effort_that_a_urdf_states(team: Team, tmp_path: Path) -> None:
    """A pole had 100 N·m in its URDF, and friction of 0.01 N·m·s/rad was tried at 0.6."""
    tried = []
    for limit in ("13.78", "1000"):
        stated = team.copy()
        stated.files = {n: t.replace('effort="13.78', f'effort="{limit}') for n, t in stated.files.items()}
        plant = build_plant(load_scenario(stated.write(tmp_path / limit)))
        assert f'effort="{limit}"' in stated.files["arm.urdf"]
        tried.append(EFFECTS["coulomb_friction"].first_size(plant, 1)["torque"])
    assert tried[0] == tried[1]
