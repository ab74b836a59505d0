"""Readings that no motion leads to: placeholders of what was lost, and those of a second sender on the topic."""

import sys
from pathlib import Path

import numpy as np
import pytest
from realitygap.check import check
from realitygap.scenario.file import load_scenario

sys.path.insert(0, str(Path(__file__).parent))  # plain modules, not a package

from teams import Team, demo


@pytest.fixture(scope="module")
def team() -> Team:
    return demo()


@pytest.mark.parametrize("value", [-999.0, 65535.0])
@pytest.mark.parametrize("where", [[200, 201], [300, 301, 500, 501, 502], [0, 1]])
def test_placeholders_of_lost_readings_are_told(value: float, where: list[int], team: Team, tmp_path: Path) -> None:
    """A single one is mended as it is read; these were compared as positions, and a limit of the URDF left out."""
    spoilt = team.copy()
    name, table = list(spoilt.tables.items())[-1]
    table.position[where, 1] = value
    found = check(load_scenario(spoilt.write(tmp_path)))
    (told,) = (m for m in found if m.kind == "placeholder")
    assert (told.certainty, told.joints, told.runs) == ("certain", ("elbow",), (name,))
    assert f"is {value:.6g} rad in {len(where)} readings, and from -" in told.text


@pytest.mark.parametrize("every", [2, 3, 10])
@pytest.mark.parametrize("noise", [0.0, 1e-3])
def test_a_second_sender_of_the_same_joints_is_told(every: int, noise: float, team: Team, tmp_path: Path) -> None:
    """As a joint_state_publisher, which says 0 of all joints, beside the driver of the robot."""
    spoilt = team.copy()
    rng = np.random.default_rng(1)
    for table in spoilt.tables.values():
        table.position += noise * rng.standard_normal(table.position.shape)
        table.position[::every, 1] = 0.0
    found = check(load_scenario(spoilt.write(tmp_path)))
    (told,) = (m for m in found if m.kind == "two_senders")
    assert (told.certainty, told.joints, len(told.runs)) == ("likely", ("elbow",), len(team.tables))
    assert told.text.startswith("recordings.columns.position: ")


@pytest.mark.parametrize("motion", ["noise", "triangle", "quanta", "told to"])
def test_noise_reversals_and_quanta_are_no_second_sender(motion: str, team: Team, tmp_path: Path) -> None:
    honest = team.copy()
    rng = np.random.default_rng(2)
    for table in honest.tables.values():
        k = np.arange(len(table.time))
        if motion == "noise":
            table.position += 0.02 * rng.standard_normal(table.position.shape)
        elif motion == "triangle":
            table.position[:] = table.command[:] = 0.1 * np.abs(k % 16 - 8)[:, None]
        elif motion == "quanta":
            table.position += 2 * np.pi / 4096 * (k % 2)[:, None]
        else:
            table.position[:] = table.command[:] = 0.5 * (k % 2)[:, None]
    assert not {"two_senders", "placeholder"} & {m.kind for m in check(load_scenario(honest.write(tmp_path)))}
