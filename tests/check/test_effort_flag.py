"""A measured effort that is a flag or never filled is told once for all recordings, and a coarse one is none."""

import sys
from pathlib import Path

import numpy as np
import pytest
from realitygap.check import check
from realitygap.scenario.file import load_scenario
from signals import there

sys.path.insert(0, str(Path(__file__).parent))  # plain modules, not a package

from teams import Team, generated, recorded


@pytest.fixture(scope="module")
def team(tmp_path_factory: pytest.TempPathFactory) -> Team:
    return recorded(generated(1, 1, "pid"), tmp_path_factory.mktemp("robot"), 1)


@pytest.mark.parametrize(
    ("values", "told"), [((0.0,), "is 0 N·m"), ((0.0, 1.0), "is 0 or 1 N·m"), ((7.0,), "is 7 N·m")]
)
def test_an_effort_that_is_none_is_told(values: tuple[float, ...], told: str, team: Team, tmp_path: Path) -> None:
    flagged = team.copy()
    for number, table in enumerate(flagged.tables.values()):
        effort = there(table.effort)
        effort[:] = values[number % len(values)]
    (found,) = check(load_scenario(flagged.write(tmp_path)))
    assert (found.kind, found.certainty, found.joints) == ("effort_size", "likely", ("lift",))
    assert found.sentence.startswith(f"the effort of lift {told} in all ")
    assert found.runs == tuple(flagged.tables)
    flagged.scenario["accept"] = ["effort_size@lift"]
    assert check(load_scenario(flagged.write(tmp_path))) == [found]


def test_a_coarse_effort_is_one(team: Team, tmp_path: Path) -> None:
    coarse = team.copy()
    for table in coarse.tables.values():
        effort = there(table.effort)
        effort[:] = np.round(effort / (0.7 * np.abs(effort).max())) * 0.7 * np.abs(effort).max()
    assert [m for m in check(load_scenario(coarse.write(tmp_path))) if "a flag" in m.text] == []
