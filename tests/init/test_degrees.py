"""Angles in degrees in a table are drafted as such where the check is certain, and a clean draft is left as it is."""

import sys
from itertools import combinations
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from first_scenario import read_all
from realitygap.check import check
from realitygap.check.observed import observe
from realitygap.init.draft import init
from realitygap.scenario.file import load_scenario
from signals import Signals, there

sys.path.insert(0, str(Path(__file__).parents[1] / "check"))  # plain modules, not a package

from teams import Team, generated, recorded

ANGLES = ("position", "velocity", "command")
SUBSETS = [turned for count in range(4) for turned in combinations(ANGLES, count)]


@pytest.fixture(scope="module")
def team(tmp_path_factory: pytest.TempPathFactory) -> Team:
    return recorded(generated(7, 2, "pid", effort=False), tmp_path_factory.mktemp("robot"), 7)


def tables(team: Team, folder: Path, suffix: str, turned: dict[str, list[int]]) -> list[Path]:
    """The recordings as files, with the columns that are turned, by signal, in degrees."""
    out = []
    for name, table in team.tables.items():
        frame = pd.DataFrame({"time": table.time})
        for signal in ANGLES:
            for j, joint in enumerate(team.joints):
                value = getattr(table, signal)[:, j]
                frame[f"{signal}_{joint}"] = np.degrees(value) if j in turned.get(signal, []) else value
        out.append(folder / f"{name}{suffix}")
        frame.to_parquet(out[-1]) if suffix == ".parquet" else frame.to_csv(out[-1], index=False)
    (folder / "robot.urdf").write_text(team.files["robot.urdf"])
    return out


def agrees(team: Team, path: Path) -> None:
    """The draft is clean by its own check, and reads what the team recorded."""
    assert check(load_scenario(path)) == []
    _, recordings = read_all(path, team.joints)
    for recording, table in zip(recordings, team.tables.values(), strict=True):
        trace = Signals(recording.trace)
        for signal in ("position", "velocity"):
            np.testing.assert_allclose(getattr(trace, signal), getattr(table, signal), atol=1e-9)
        np.testing.assert_allclose(recording.command, table.command, atol=1e-9)


@pytest.mark.parametrize("turned", SUBSETS, ids=lambda turned: "+".join(turned) or "none")
@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_every_signal_is_drafted_in_its_own_unit(
    suffix: str, turned: tuple[str, ...], team: Team, tmp_path: Path
) -> None:
    every = list(range(len(team.joints)))
    draft = init(
        tmp_path / "robot.urdf", tables(team, tmp_path, suffix, dict.fromkeys(turned, every)), tmp_path / "out"
    )
    agrees(team, draft.path)
    said = [line for line in draft.guessed if line.startswith("units")]
    assert len(said) == (1 if turned else 0)
    assert all("divided by 57.3" in line or "times" in line for line in said)
    units = there(there(load_scenario(draft.path).scenario.recordings).columns.units)
    assert {s for s in ANGLES if getattr(units, s) == "deg"} == set(turned)


@pytest.mark.parametrize("turned", [s for s in SUBSETS if "position" in s], ids="+".join)
def test_so_is_an_angle_that_begins_again_after_360(turned: tuple[str, ...], team: Team, tmp_path: Path) -> None:
    """No angle in rad does so, and no encoder counts to 360."""
    every = list(range(len(team.joints)))
    paths = tables(team, tmp_path, ".csv", dict.fromkeys(turned, every))
    for path in paths:
        frame = pd.read_csv(path)
        for column in (c for c in map(str, frame) if c.startswith(tuple({"position", "command"} & set(turned)))):
            frame[column] = np.mod(frame[column], 360.0)
        frame.to_csv(path, index=False)
    draft = init(tmp_path / "robot.urdf", paths, tmp_path / "out")
    file = load_scenario(draft.path)
    assert check(file) == []
    units = there(there(file.scenario.recordings).columns.units)
    assert {s for s in ANGLES if getattr(units, s) == "deg"} == set(turned)
    for o, table in zip(observe(file), team.tables.values(), strict=True):
        np.testing.assert_allclose(Signals(o.recording.trace).position, table.position, atol=1e-9)
        np.testing.assert_allclose(o.recording.command, table.command, atol=1e-9)


@pytest.mark.parametrize("joint", [0, 1])
def test_a_position_in_degrees_beside_another_that_its_velocity_says_is_not(
    joint: int, team: Team, tmp_path: Path
) -> None:
    turned = {"position": [joint]}
    agrees(team, init(tmp_path / "robot.urdf", tables(team, tmp_path, ".csv", turned), tmp_path / "out").path)


def test_a_unit_that_a_name_says_is_kept(team: Team, tmp_path: Path) -> None:
    paths = tables(team, tmp_path, ".csv", {s: [0, 1] for s in ("position", "velocity")})
    for path in paths:
        frame = pd.read_csv(path)
        frame.columns = [f"{c}_deg" if c.startswith("velocity") else c for c in frame.columns]
        frame.to_csv(path, index=False)
    agrees(team, init(tmp_path / "robot.urdf", paths, tmp_path / "out").path)
