"""Planted mistakes are named as what they are, where they are, and nothing else is said. All: bench_check.py."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[1]))  # plain modules, not a package

from bench_check import ROBOTS, fits, found
from spoil import MISTAKES, Planted
from teams import Team, demo, generated, recorded


@pytest.fixture(scope="module")
def teams(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Team]:
    out = {"two joints, the demo": demo()}
    for name in ("one joint, dc", "one slide", "six joints, dc"):
        seed, n, kind = ROBOTS[name]
        out[name] = recorded(generated(seed, n, kind), tmp_path_factory.mktemp("robot"), seed)
    return out


@pytest.mark.parametrize("planted", MISTAKES, ids=lambda m: m.name)
def test_a_mistake_is_named_as_what_it_is(planted: Planted, teams: dict[str, Team], tmp_path: Path) -> None:
    """On one robot that it can happen to, another for every mistake."""
    able = [name for name, team in teams.items() if fits(planted, team)]
    number = MISTAKES.index(planted)
    team = teams[able[number % len(able)]]
    ok, said = found(planted, team, number % len(team.joints) if planted.where != "any" else 0, tmp_path)
    assert ok, said
