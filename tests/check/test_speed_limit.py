"""A velocity limit that the simulation keeps and the robot did not is told; what was dragged past one is not."""

import sys
from pathlib import Path

import numpy as np
import pytest
from realitygap.check import certain, check
from realitygap.robot.plant import Plant
from realitygap.scenario.file import load_scenario

sys.path.insert(0, str(Path(__file__).parent))  # plain modules, not a package

from teams import Team, generated, recorded


def unlimited(plant: Plant, _: np.random.Generator) -> Plant:
    plant.drive["velocity_limit"] = np.inf
    return plant


def slowed(team: Team, share: float) -> Team:
    """The same with a URDF that says a share of the limit of the first joint."""
    out = team.copy()
    head, _, rest = out.files["robot.urdf"].partition('velocity="')
    number, _, tail = rest.partition('"')
    out.files["robot.urdf"] = f'{head}velocity="{float(number) * share:.6g}"{tail}'
    return out


@pytest.fixture(scope="module")
def fast(tmp_path_factory: pytest.TempPathFactory) -> Team:
    return recorded(generated(2, 1, "pid"), tmp_path_factory.mktemp("robot"), 2, unlimited)


@pytest.mark.parametrize("told", [("velocity", "effort"), ("effort",), ("velocity",), ()], ids=str)
def test_a_joint_that_was_driven_past_its_limit_is_told(told: tuple[str, ...], fast: Team, tmp_path: Path) -> None:
    """By its positions: with a velocity or without, with an effort or by what its links take."""
    team = slowed(fast, 0.4)
    for table in team.tables.values():
        table.velocity = table.velocity if "velocity" in told else np.full_like(table.velocity, np.nan)
        table.effort = table.effort if "effort" in told else None
    team.scenario["recordings"]["effort"] = "motor" if "effort" in told else "none"
    file = load_scenario(team.write(tmp_path))
    (found,) = certain(file)
    assert (found.kind, found.certainty, found.joints, found.key) == (
        "velocity_limit",
        "likely",
        ("lift",),
        "robot.urdf",
    )
    assert found.sentence.startswith("lift was measured at ")
    assert certain(file.override({"accept": ["velocity_limit@lift"]})) == []


@pytest.mark.parametrize("why", ["it keeps it", "noise", "a reading that is off", "a dc servo has none"])
def test_one_that_was_not_is_not(why: str, fast: Team, tmp_path: Path) -> None:
    team = fast
    if why == "it keeps it":
        team = recorded(slowed(generated(2, 1, "pid"), 0.4), tmp_path / "robot", 2)
    elif why == "a dc servo has none":
        team = slowed(recorded(generated(1, 1, "dc"), tmp_path / "robot", 1), 0.4)
    else:
        team = slowed(fast, 50.0)
        for number, table in enumerate(team.tables.values()):
            rng = np.random.default_rng(number)
            table.velocity += (1000.0 if why == "noise" else 0.0) * rng.standard_normal(table.velocity.shape)
            table.position[100::150] += 9.0 if why == "a reading that is off" else 0.0
    assert [m for m in check(load_scenario(team.write(tmp_path))) if m.kind == "velocity_limit"] == []
