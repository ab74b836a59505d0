"""No mistake is seen where there is none: in real recordings, and where physics is to blame. More: bench_check.py."""

import json
import sys
from pathlib import Path

import pytest
from realitygap.check import accepted, check
from realitygap.scenario.file import load_scenario

sys.path.insert(0, str(Path(__file__).parents[1]))  # plain modules, not a package

from bench_check import SCENARIOS, physics_case, scenario_files
from bench_long import scenario, urdf, write_parquet


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


def test_a_long_recording_is_no_mistake(tmp_path: Path) -> None:
    """Ten minutes of twenty joints that swing along one sine each: nothing is read off what averages to rounding."""
    (tmp_path / "row.urdf").write_text(urdf(20))
    write_parquet(tmp_path / "long.parquet", 60_000, 100.0, 20)
    (tmp_path / "scenario.yaml").write_text(json.dumps(scenario("long.parquet", 1000.0)))
    assert [m.text for m in check(load_scenario(tmp_path / "scenario.yaml"))] == []
