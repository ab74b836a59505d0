"""A joint that mimics another in the URDF and was measured elsewhere is told, with the coupling that fits if any."""

import sys
from pathlib import Path

import numpy as np
import pytest
from realitygap.check import Mistake, check
from realitygap.scenario.file import load_scenario

sys.path.insert(0, str(Path(__file__).parent))  # plain modules, not a package

from teams import Team, demo


@pytest.fixture(scope="module")
def team() -> Team:
    """Whose elbow is -1 times its shoulder, and 0.2, in the URDF; recorded on its own."""
    out = demo()
    elbow = '<joint name="elbow" type="revolute">'
    out.files = {
        name: text.replace(elbow, f'{elbow}<mimic joint="shoulder" multiplier="-1" offset="0.2"/>')
        for name, text in out.files.items()
    }
    return out


def coupled(team: Team, folder: Path, multiplier: float, offset: float) -> list[Mistake]:
    """What is found of a coupling where the elbow was measured at one, with some play."""
    led = team.copy()
    for table in led.tables.values():
        for signal in ("position", "velocity", "command"):
            value = getattr(table, signal)
            value[:, 1] = multiplier * value[:, 0] + (0.0 if signal == "velocity" else offset)
        table.position[:, 1] += 0.02 * np.sign(table.velocity[:, 1])
    return [m for m in check(load_scenario(led.write(folder))) if m.kind == "coupling"]


def test_a_coupling_that_the_recordings_keep_to_is_no_mistake(team: Team, tmp_path: Path) -> None:
    assert coupled(team, tmp_path, -1.0, 0.2) == []


def test_one_that_they_break_is_told(team: Team, tmp_path: Path) -> None:
    (found,) = [m for m in check(load_scenario(team.write(tmp_path))) if m.kind == "coupling"]
    assert (found.certainty, found.joints, found.key) == ("likely", ("elbow",), "robot.urdf")
    assert found.sentence.startswith("elbow is -1 times shoulder plus 0.2 in the robot's file, and was measured ")
    assert "explains" not in found.sentence


@pytest.mark.parametrize(("multiplier", "offset"), [(1.0, 0.2), (-0.5, 0.2), (-1.0, 1.2)])
def test_another_coupling_is_told_with_what_fits(multiplier: float, offset: float, team: Team, tmp_path: Path) -> None:
    (found,) = coupled(team, tmp_path, multiplier, offset)
    fits = found.sentence.partition(" (")[2].split()
    assert fits[1:3] == ["times", "shoulder"]
    assert (float(fits[0]), float(fits[4])) == pytest.approx((multiplier, offset), abs=0.05)
