"""Repetitions of one motion that were recorded under other conditions: told, and no physics is kept from being named
for them; those of one machine are not, whatever noise, stick and slip they have.
"""

import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from realitygap.check import Mistake, blamed_joints, check
from realitygap.scenario.file import load_scenario

sys.path.insert(0, str(Path(__file__).parent))  # plain modules, not a package

from teams import Table, Team, demo

Change = Callable[[Table, np.random.Generator], Table]


def copies(changes: list[Change], **keys: object) -> Team:
    """A team whose motion was recorded again and again, changed each time."""
    team = demo()
    name, first = next(iter(team.tables.items()))
    random = np.random.default_rng(0)
    copy = {k: v.copy() for k, v in vars(first).items() if v is not None}
    team.tables = {f"{name}_{k}": change(replace(first, **copy), random) for k, change in enumerate(changes)}
    team.scenario["recordings"]["runs"] = [dict(keys) for _ in changes]
    return team


def again(table: Table, random: np.random.Generator) -> Table:
    """A repetition of the same machine: noise of the sensors, and a friction that differs by a tenth."""
    position = table.position + 1e-4 * random.standard_normal(table.position.shape)
    position += 0.1 * random.uniform(-1, 1) * (table.position - table.command) * np.cos(5 * table.time[:, None])
    effort = None if table.effort is None else table.effort * (1 + 0.1 * random.uniform(-1, 1))
    return replace(table, position=position, effort=effort)


def soft(table: Table, random: np.random.Generator) -> Table:
    """A quarter of the gain."""
    lag = table.position - table.command
    return replace(again(table, random), position=table.command + 4 * lag)


def loaded(table: Table, random: np.random.Generator) -> Table:
    """A load that doubles the efforts, and that a stiff controller carries along the same way."""
    assert table.effort is not None
    return replace(again(table, random), effort=2 * table.effort)


def found(team: Team, folder: Path) -> list[Mistake]:
    return check(load_scenario(team.write(folder)))


@pytest.mark.parametrize("changes", [[again, again], [again] * 5])
def test_repetitions_of_one_machine_are_no_mistake(changes: list[Change], tmp_path: Path) -> None:
    assert found(copies(changes), tmp_path) == []


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ([again, soft], "position error of"),
        ([again, again, again, soft], "position error of"),
        ([again, loaded], "effort of"),
    ],
)
def test_repetitions_under_other_conditions_are_told(changes: list[Change], said: str, tmp_path: Path) -> None:
    (mistake,) = found(copies(changes), tmp_path)
    assert (mistake.kind, mistake.certainty) == ("other_conditions", "likely")
    assert said in mistake.sentence
    assert f"_0 and {next(iter(demo().tables))}_{len(changes) - 1}" in mistake.sentence
    assert blamed_joints([mistake]) == set()


def test_conditions_that_the_scenario_states_are_none(tmp_path: Path) -> None:
    team = copies([again, soft])
    team.scenario["recordings"]["runs"][1]["with"] = {"physics.step_rate": 500}
    assert found(team, tmp_path) == []
    team.scenario["recordings"]["runs"][1].pop("with")
    team.scenario["accept"] = ["other_conditions"]
    assert [m.kind for m in found(team, tmp_path)] == ["other_conditions"]


def test_a_payload_and_a_gain_of_real_robots_are_other_conditions(data_dir: Path, tmp_path: Path) -> None:
    scenarios = Path(__file__).parents[2] / "scenarios"
    for name, paths in (
        ("ur10e", ["ur10e/free_1.csv", "ur10e/loaded_1.csv"]),
        ("sts3215_pendulum", [f"sts3215_pendulum/sin_sin_m0.535_l0.10_kp{kp}_rep1.csv" for kp in (8, 16, 32)]),
    ):
        raw = yaml.safe_load((scenarios / name / "scenario.yaml").read_text())
        raw["recordings"]["runs"] = [{"path": str(data_dir / path)} for path in paths]
        raw["robot"]["urdf"] = (
            str((scenarios / name / raw["robot"]["urdf"]).resolve())
            if name != "ur10e"
            else str(data_dir / "ur10e" / "ur10e.urdf")
        )
        path = tmp_path / f"{name}.yaml"
        path.write_text(yaml.safe_dump(raw))
        assert [m.kind for m in check(load_scenario(path))] == ["other_conditions"], name
