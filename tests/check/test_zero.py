"""A zero that is off by less than servos sag is told where the measured effort contradicts it, and no sag is one."""

import sys
from pathlib import Path

import numpy as np
import pytest
from realitygap.check import check
from realitygap.robot.effects.place import place
from realitygap.robot.plant import Plant
from realitygap.scenario.file import load_scenario
from realitygap.scenario.schema import EffectSpec

sys.path.insert(0, str(Path(__file__).parent))  # plain modules, not a package

from teams import Team, generated, recorded


@pytest.fixture(scope="module", params=["dc", "pid"])
def team(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Team:
    return recorded(generated(1, 1, request.param), tmp_path_factory.mktemp("robot"), 1)


def read_off(team: Team, offset: float) -> Team:
    out = team.copy()
    for table in out.tables.values():
        table.position += offset
    return out


@pytest.mark.parametrize("offset", [0.3, -0.3, 0.5, -0.6])
def test_another_zero_is_told_with_its_angle(offset: float, team: Team, tmp_path: Path) -> None:
    (found,) = check(load_scenario(read_off(team, offset).write(tmp_path)))
    assert (found.kind, found.certainty, found.joints) == ("far_zero", "likely", ("lift",))
    told = float(found.sentence.removeprefix("the position of lift is ").split()[0])
    assert told == pytest.approx(offset, abs=0.03)
    assert len(found.runs) > 1


def test_without_an_effort_it_may_be_a_sag(team: Team, tmp_path: Path) -> None:
    low = read_off(team, -0.3)
    low.scenario["recordings"]["effort"] = "none"
    assert check(load_scenario(low.write(tmp_path))) == []


WEAKER = 0.08
"""A gain that is this share of what the scenario says lets a link hang."""


def weak(plant: Plant, _: np.random.Generator) -> Plant:
    plant.drive["gain"] *= WEAKER
    plant.drive["kp"] *= WEAKER
    return plant


def pushed(plant: Plant, _: np.random.Generator) -> Plant:
    most = 0.25 * float(plant.drive["effort_limit"][0])
    spec = {"effect": "constant_effort", "target": "lift", "effort": most}
    return weak(place(plant, [EffectSpec.model_validate(spec)]), _)


def turned(plant: Plant, _: np.random.Generator) -> Plant:
    spec = {"effect": "joint_offset", "target": "lift", "angle": 0.18}
    return place(plant, [EffectSpec.model_validate(spec)])


@pytest.mark.parametrize("change", [weak, pushed, turned])
@pytest.mark.parametrize("kind", ["dc", "pid"])
def test_a_joint_that_hangs_has_no_other_zero(kind: str, change, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    hung = recorded(generated(1, 1, kind), tmp_path / "robot", 1, change)
    away = [float(np.median(t.position - t.command)) for t in hung.tables.values()]
    if change is pushed:
        assert max(map(abs, away)) > 0.25
    assert [m.text for m in check(load_scenario(hung.write(tmp_path))) if m.kind == "far_zero"] == []
