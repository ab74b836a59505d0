"""Units that the names of columns say, of all joints or of each its own."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from first_scenario import arm, goal, read_all
from realitygap.files.errors import InputError
from realitygap.init.draft import init
from realitygap.scenario.file import load_scenario
from signals import Signals, there

CLOCK = np.arange(100) * 0.01
JOINTS = ("shoulder", "elbow")
RATE = np.gradient(goal(CLOCK), CLOCK)
DEG, RPM = 180 / np.pi, 30 / np.pi


@pytest.mark.parametrize(
    ("columns", "factors"),
    [
        (("shoulder_pos_deg", "elbow_pos_rad"), (DEG, 1.0)),
        (("shoulder [°]", "elbow [rad]"), (DEG, 1.0)),
        (("q1_mrad", "q2_deg"), (1e3, DEG)),
        (("pos1 [m°]", "pos2 [m°]"), (1e3 * DEG, 1e3 * DEG)),
        (("pos1 (mdeg)", "pos2 (mm)"), (1e3 * DEG, 1e3)),
        (("winkel1 pos [Grad]", "winkel2 pos [Grad]"), (DEG, DEG)),
        (("pos1_cm", "pos2_m"), (100.0, 1.0)),
        (("shoulder pos [turns]", "elbow pos [rev]"), (0.5 / np.pi, 0.5 / np.pi)),
    ],
)
def test_each_column_of_positions_is_in_the_unit_that_its_name_says(
    columns: tuple[str, str], factors: tuple[float, float], tmp_path: Path
) -> None:
    frame = pd.DataFrame({"time": CLOCK})
    for k in (0, 1):
        frame[columns[k]], frame[f"{JOINTS[k]}_goal"] = goal(CLOCK) * factors[k], goal(CLOCK)
    frame.to_csv(tmp_path / "run.csv", index=False)
    draft = init(arm(tmp_path / "arm.urdf"), [tmp_path / "run.csv"], tmp_path / "out")
    _, (recording,) = read_all(draft.path, JOINTS)
    np.testing.assert_allclose(Signals(recording.trace).position, np.tile(goal(CLOCK)[:, None], 2), atol=1e-9)
    np.testing.assert_allclose(Signals(recording.trace).command, np.tile(goal(CLOCK)[:, None], 2))


def test_velocities_and_their_commands_may_be_revolutions_per_minute(tmp_path: Path) -> None:
    frame = pd.DataFrame({"time_ms": 1e3 * CLOCK})
    for joint, unit in zip(JOINTS, (RPM, DEG), strict=True):
        name = "rpm" if unit == RPM else "deg/s"
        frame[f"{joint}_pos"] = goal(CLOCK)
        frame[f"{joint}_speed_{name}"], frame[f"{joint}_speed_cmd_rpm"] = RATE * unit, np.cos(CLOCK) * RPM
    frame.to_csv(tmp_path / "run.csv", index=False)
    draft = init(arm(tmp_path / "arm.urdf"), [tmp_path / "run.csv"], tmp_path / "out")
    scenario, (recording,) = read_all(draft.path, JOINTS)
    np.testing.assert_allclose(Signals(recording.trace).velocity, np.tile(RATE[:, None], 2))
    np.testing.assert_allclose(recording.command, np.tile(np.cos(CLOCK)[:, None], 2))
    assert there(scenario.motion).meaning == "velocity"
    asked = load_scenario(draft.path).override({"motion.as": "position"})
    draft.path.write_text(draft.path.read_text().replace("as: velocity", "as: position"))
    assert there(asked.scenario.motion).meaning == "position"
    with pytest.raises(InputError, match=r"units.command: found rpm of commands that are `as: position`; expected `as"):
        read_all(draft.path, JOINTS)


def test_a_velocity_in_m_per_s_is_not_one_in_ms(tmp_path: Path) -> None:
    frame = pd.DataFrame({"time": CLOCK})
    for joint in JOINTS:
        frame[f"{joint}_pos"], frame[f"{joint}_vel_ms"], frame[f"{joint}_goal"] = goal(CLOCK), RATE, goal(CLOCK)
    frame.to_csv(tmp_path / "run.csv", index=False)
    draft = init(arm(tmp_path / "arm.urdf"), [tmp_path / "run.csv"], tmp_path / "out")
    np.testing.assert_allclose(Signals(read_all(draft.path, JOINTS)[1][0].trace).velocity[:, 0], RATE)


@pytest.mark.parametrize("per", ["U/min", "1/min", "rpm", "rev/min"])
def test_german_words_and_revolutions(per: str, tmp_path: Path) -> None:
    """As a laboratory's table has them, also written as one word."""
    frame = pd.DataFrame({"Zeit [s]": CLOCK})
    signals = {
        ("", "Winkel", "Grad"): goal(CLOCK) * DEG,
        ("Soll", "winkel", "Grad"): np.cos(CLOCK) * DEG,
        ("", "Drehzahl", per): RATE * RPM,
        ("", "Drehmoment", "Nm"): np.sin(CLOCK),
        ("", "Strom", "A"): np.cos(CLOCK),
        ("", "Temperatur", "C"): np.full(len(CLOCK), 30.0),
    }
    for joint in JOINTS:
        for (word, quantity, unit), value in signals.items():
            frame[f"{joint} {word}{quantity} [{unit}]"] = value
    frame.to_csv(tmp_path / "run.csv", index=False, sep=";", decimal=",", encoding="latin-1")
    draft = init(arm(tmp_path / "arm.urdf"), [tmp_path / "run.csv"], tmp_path / "out")
    _, (recording,) = read_all(draft.path, JOINTS)
    trace = Signals(recording.trace)
    expected = {"position": goal(CLOCK), "velocity": RATE, "effort": np.sin(CLOCK), "command": np.cos(CLOCK)}
    for signal, value in expected.items():
        np.testing.assert_allclose(getattr(trace, signal), np.tile(value[:, None], 2), atol=1e-9, err_msg=signal)
