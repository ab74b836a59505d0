"""How far the engines are from one another on a real humanoid: standing on grass, cheering on rigid ground."""

import itertools
import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import realitygap_engines as engines
from realitygap.scenario.file import load_scenario
from realitygap.simulate.experiment import experiments, simulate

SCENARIO = Path(__file__).parents[2] / "scenarios" / "wolfgang_cheering" / "scenario.yaml"
NAMES = engines.available()


def spread(changes: dict[str, object], seconds: float) -> dict[tuple[str, str], float]:
    """Root mean square difference [rad] of all joint positions between every two engines, at 1 ms."""
    experiment = replace(experiments(load_scenario(SCENARIO).override(changes))[0], duration=seconds)
    positions = {name: simulate(experiment, name, step_rate=1000).trace.position for name in NAMES}
    out = {}
    for a, b in itertools.combinations(NAMES, 2):
        first, second = positions[a], positions[b]
        assert first is not None
        assert second is not None
        out[a, b] = float(np.sqrt(np.mean((first - second) ** 2)))
    return out


@pytest.fixture(autouse=True)
def _data(data_dir: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(os.environ, "REALITYGAP_DATA", str(data_dir))


@pytest.mark.parametrize("kd", [0.1, 0.4])
def test_standing_on_grass(kd: float) -> None:
    """2e-4 rad; the first keyframe is the stance, held for 1.5 s."""
    found = spread({"ground": "grass", "servos.all.kd": kd}, 1.5)
    assert max(found.values()) < 2e-4, found


@pytest.mark.parametrize("revision", ["old", "link_revised", "joint_revised"])
def test_cheering_on_rigid_ground(revision: str) -> None:
    """4e-4 rad over the arm movements, with dry friction of 0.1 N·m in two revisions and of 1 N·m in the third.

    At 3.5 s the robot rocks, and joints stay where dry friction then holds them.
    """
    found = spread({"robot.urdf": f"${{REALITYGAP_DATA}}/wolfgang_2019/urdf/wolfgang_{revision}.urdf"}, 6.0)
    assert max(found.values()) < 4e-4, found
