"""An arm (synthetic) whose derivative gain nobody wrote down: the guess is named, and no friction in its place."""

from pathlib import Path

import numpy as np
import pytest
import realitygap as rg
import yaml

URDF = """<robot name="arm"><link name="base"/><link name="arm"><inertial><origin xyz="0 0 -0.15"/><mass value="0.5"/>
<inertia ixx="2e-3" iyy="2e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="hinge" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" effort="10" velocity="20"/><dynamics damping="0.02" friction="0.05"/></joint></robot>"""
TRUE, GUESSED = 1.2, 0.14
QUANTUM = 2e-4
TIME = np.arange(0.0, 4.0, 0.005)
MOTIONS = {
    "sweep": 0.6 * np.sin(2.0 * np.pi * (0.4 + 0.5 * TIME) * TIME),
    "steps": 0.5 * np.sign(np.sin(2.0 * np.pi * 0.7 * TIME)) * np.minimum(TIME, 1.0),
    "sines": 0.4 * np.sin(4.0 * TIME) + 0.2 * np.sin(11.0 * TIME),
}


def record(folder: Path, name: str, position: np.ndarray) -> None:
    rows = zip(TIME, MOTIONS[name], QUANTUM * np.round(position / QUANTUM), strict=True)
    table = "".join(f"{t:.3f},{c:.6f},{q:.6f}\n" for t, c, q in rows)
    (folder / f"{name}.csv").write_text(f"time,command,position\n{table}")


@pytest.fixture(scope="module")
def scenario(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Recordings of DART with the true gain, of which the scenario holds the guess that `init` makes."""
    folder = tmp_path_factory.mktemp("guessed")
    (folder / "arm.urdf").write_text(URDF)
    runs = [{"path": f"{name}.csv", "use": "held_out" if name == "sines" else "train"} for name in MOTIONS]
    content = {
        "name": "guessed",
        "robot": {"urdf": "arm.urdf", "base": "fixed"},
        "servos": [{"joints": "*", "kind": "pid", "kp": 28.0, "kd": GUESSED}],
        "motion": {"recorded": "command", "held": False},
        "physics": {"step_rate": 1000},
        "recordings": {"effort": "none", "runs": runs},
    }
    path, random = folder / "scenario.yaml", np.random.default_rng(5)
    path.write_text(yaml.safe_dump(content, sort_keys=False))
    for name in MOTIONS:  # to know the commands
        record(folder, name, np.zeros(len(TIME)))
    true = rg.effects.derivative_gain("hinge", gain=TRUE)
    for name in MOTIONS:
        position = rg.simulate(path, "dart", run=name, effects=[true]).at(TIME).position
        assert position is not None
        record(folder, name, position[:, 0] + 0.3 * QUANTUM * random.standard_normal(len(TIME)))
    return path


def test_a_guessed_derivative_gain_is_named(scenario: Path) -> None:
    told = rg.diagnose(scenario, engines=["mujoco"])
    assert [(f.effect, f.target) for f in told.findings] == [("derivative_gain", "hinge")]
    assert told.findings[0].parameters["gain"] == pytest.approx(TRUE, rel=0.05)
    assert told.verdict == "explained"
