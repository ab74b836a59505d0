"""No mistake is seen where there is none: in real recordings, and where physics is to blame. More: bench_check.py."""

import sys
from pathlib import Path

import pytest
from realitygap.check import accepted, check
from realitygap.scenario.file import load_scenario

sys.path.insert(0, str(Path(__file__).parents[1]))  # plain modules, not a package

from bench_check import SCENARIOS, physics_case, scenario_files


@pytest.mark.parametrize("path", scenario_files(), ids=lambda p: p.relative_to(SCENARIOS).as_posix())
def test_scenarios_of_this_repository_are_without_mistakes(path: Path, request: pytest.FixtureRequest) -> None:
    if "REALITYGAP_DATA" in path.read_text():
        request.getfixturevalue("data_dir")
    file = load_scenario(path)
    assert [m.text for m in check(file) if not accepted(file, m)] == []


ONCE_BLAMED = (41148, 41178)
"""Whose ripple and gains were taken for a flipped sign and for another unit."""


@pytest.mark.parametrize("seed", [*range(1001, 1015), *ONCE_BLAMED])
def test_planted_physics_is_no_mistake(seed: int, tmp_path: Path) -> None:
    made = physics_case(seed, tmp_path)
    if made is None:
        pytest.skip("the robot blew up")
    told, team = made
    assert [m.text for m in check(load_scenario(team.write(tmp_path)))] == [], told
