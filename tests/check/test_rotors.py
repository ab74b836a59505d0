"""Rotors behind gears, of which a model says nothing, move far more than a light wrist does: that is no mistake."""

from pathlib import Path

import numpy as np
import pytest
import yaml
from realitygap.check import check
from realitygap.robot.plant import build_plant
from realitygap.scenario.file import load_scenario
from realitygap_engines import GRAVITY
from realitygap_engines.law.dynamics import Dynamics

URDF = """<robot name="arm"><link name="base"/>
<link name="upper"><inertial><origin xyz="0.3 0 0"/><mass value="6"/>
<inertia ixx="0.02" ixy="0" ixz="0" iyy="0.2" iyz="0" izz="0.2"/></inertial></link>
<link name="hand"><inertial><origin xyz="0.02 0 -0.02"/><mass value="0.5"/>
<inertia ixx="0.0002" ixy="0" ixz="0" iyy="0.0004" iyz="0" izz="0.0004"/></inertial></link>
<link name="flange"><inertial><mass value="0.1"/>
<inertia ixx="0.0001" ixy="0" ixz="0" iyy="0.0001" iyz="0" izz="0.0002"/></inertial></link>
<joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" effort="150" velocity="3"/></joint>
<joint name="bend" type="revolute"><parent link="upper"/><child link="hand"/><origin xyz="0.6 0 0"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" effort="30" velocity="3"/></joint>
<joint name="turn" type="revolute"><parent link="hand"/><child link="flange"/><origin xyz="0.05 0 0"/>
<axis xyz="1 0 0"/>
<limit lower="-3" upper="3" effort="30" velocity="3"/></joint></robot>"""
JOINTS = ("shoulder", "bend", "turn")
ROTORS = np.array([0.5, 0.8, 0.25])


def arm(folder: Path, factor: dict[str, float]) -> Path:
    """A scenario that follows sines, with efforts of links, rotors and friction, of some joints times a factor."""
    (folder / "arm.urdf").write_text(URDF, encoding="utf-8")
    content = {
        "name": "arm",
        "robot": {"urdf": "arm.urdf", "base": "fixed"},
        "motion": {"followed": True},
        "recordings": {"virtual": True, "effort": "motor", "runs": [{"path": "sines.csv", "use": "train"}]},
    }
    file = folder / "scenario.yaml"
    file.write_text(yaml.safe_dump(content), encoding="utf-8")
    time, speed = np.arange(0.0, 12.0, 0.01), np.array([0.4, 2.9, 3.7])
    phase = np.outer(time, speed)
    q, w, a = 0.6 * np.sin(phase), 0.6 * speed * np.cos(phase), -0.6 * speed**2 * np.sin(phase)
    base = np.zeros(13)
    base[3] = 1.0
    (folder / "sines.csv").write_text("time\n0\n", encoding="utf-8")
    model = build_plant(load_scenario(file)).model
    links = Dynamics(model).inverse(q, w, a, base, np.array([0.0, 0.0, -GRAVITY]))
    effort = (links + ROTORS * a + 1.5 * np.tanh(w / 0.05)) * [factor.get(j, 1.0) for j in JOINTS]
    header = ",".join(["time", *(f"{s}_{j}" for s in ("position", "effort") for j in JOINTS)])
    table = np.column_stack([time, q, effort])
    np.savetxt(folder / "sines.csv", table, fmt="%.7g", delimiter=",", header=header, comments="")
    return file


def test_a_rotor_that_is_heavier_than_its_wrist_is_no_mistake(tmp_path: Path) -> None:
    assert [m.text for m in check(load_scenario(arm(tmp_path, {})))] == []


@pytest.mark.parametrize(("factor", "kind"), [(1000.0, "milliamperes"), (-1.0, "flipped_sign")])
def test_an_effort_that_no_rotor_makes_is_one(factor: float, kind: str, tmp_path: Path) -> None:
    found = check(load_scenario(arm(tmp_path, {"shoulder": factor})))
    assert [(m.kind, m.joints) for m in found] == [(kind, ("shoulder",))]
