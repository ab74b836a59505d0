"""Velocities of joints at rest are noise, and none of it is a mistake; those of short motions are judged as ever."""

import sys
from pathlib import Path

import numpy as np
import pytest
from realitygap.check import check
from realitygap.scenario.file import load_scenario

sys.path.insert(0, str(Path(__file__).parent))  # plain modules, not a package

from spoil import DEGREES
from teams import Table, Team, demo


@pytest.fixture(scope="module")
def team() -> Team:
    return demo()


@pytest.mark.parametrize("count", [20, 34, 60, 150, 200])
@pytest.mark.parametrize("command", ["rests", "is none"])
def test_noise_at_rest_is_no_velocity_that_is_wrong(command: str, count: int, team: Team, tmp_path: Path) -> None:
    """Of sensors whose files hold a millionth: their noise is a thousand of such quanta."""
    still = team.copy()
    still.scenario["recordings"]["effort"] = "none"
    for number, name in enumerate(still.tables):
        rng, shape = np.random.default_rng([count, number]), (count, 2)
        position, velocity = (np.round(rng.normal(0.0, s, shape), 6) for s in (3e-4, 5e-3))
        told = np.zeros(shape) if command == "rests" else np.full(shape, np.nan)
        still.tables[name] = Table(0.005 * np.arange(count), told, position, velocity, None)
    found = check(load_scenario(still.write(tmp_path)))
    assert [m.text for m in found if m.key == "recordings.columns.velocity"] == []


@pytest.mark.parametrize("seconds", [0.15, 0.3, 1.0])
@pytest.mark.parametrize(("factor", "kind"), [(-1.0, "flipped_sign"), (DEGREES, "degrees"), (5.0, "velocity")])
def test_the_velocity_of_a_short_motion_is_judged(
    factor: float, kind: str, seconds: float, team: Team, tmp_path: Path
) -> None:
    """Around where the elbow is fastest."""
    short = team.copy()
    short.scenario["recordings"]["effort"] = "none"
    for table in short.tables.values():
        middle = np.clip(table.time[np.argmax(np.abs(table.velocity[:, 1]))], seconds / 2, table.time[-1] - seconds / 2)
        inside = np.abs(table.time - middle) <= seconds / 2
        for signal in ("time", "command", "position", "velocity"):
            setattr(table, signal, getattr(table, signal)[inside])
        table.velocity[:, 1] *= factor
        table.effort = None
    found = check(load_scenario(short.write(tmp_path)))
    told = {(m.kind, m.joints) for m in found if m.key == "recordings.columns.velocity"}
    assert told == {(kind, ("elbow",))}
