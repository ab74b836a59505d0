"""A scenario whose robot is a MJCF file: its actuators are the servos, unless the scenario names some."""

from pathlib import Path

import numpy as np
import pytest
import yaml
from realitygap.audit import audit
from realitygap.robot.drive import CASCADE, PID
from realitygap.robot.plant import build_plant
from realitygap.scenario.file import load_scenario

INERTIAL = '<inertial pos="0 0 -.1" mass="1.5" diaginertia=".02 .03 .04"/>'
ARM = f"""<mujoco model="arm"><compiler autolimits="true"/><worldbody><body name="base">{INERTIAL}
<body name="upper"><joint name="shoulder[1]" axis="0 1 0" armature=".01" damping=".2" frictionloss=".05"/>{INERTIAL}
<body name="lower" pos="0 0 -.2"><joint name="elbow" axis="0 1 0" armature=".02"/>{INERTIAL}</body></body></body>
</worldbody><actuator><position joint="shoulder[1]" kp="40" kv="2" forcerange="-5 5"/>
<position joint="elbow" kp="30"/></actuator>
</mujoco>"""


def scenario(folder: Path, **keys: object) -> Path:
    (folder / "arm.xml").write_text(ARM)
    path = folder / "scenario.yaml"
    path.write_text(yaml.safe_dump({"name": "x", "robot": {"urdf": "arm.xml", "base": "fixed"}, **keys}))
    return path


def test_without_servos_the_files_actuators_drive(tmp_path: Path) -> None:
    plant = build_plant(load_scenario(scenario(tmp_path)))
    assert plant.drive["kind"].tolist() == [CASCADE, PID]
    np.testing.assert_allclose(plant.drive["armature"], [0.01, 0.02])
    np.testing.assert_allclose(plant.drive["coulomb"], [0.05, 0.0])
    np.testing.assert_allclose(plant.drive["viscous"], [0.2, 0.0])
    np.testing.assert_allclose(plant.drive["effort_limit"], [5.0, np.inf])
    assert any("2 actuators in the robot's file" in note for note in plant.model.notes)


def test_servos_of_the_scenario_replace_them_and_keep_what_they_do_not_say(tmp_path: Path) -> None:
    servos = [{"joints": "elbow", "kind": "pid", "kp": 7.0, "armature": 0.5}, {"joints": "*", "kind": "pid", "kp": 9.0}]
    plant = build_plant(load_scenario(scenario(tmp_path, servos=servos)))
    np.testing.assert_allclose(plant.drive["kp"], [9.0, 7.0])
    np.testing.assert_allclose(plant.drive["armature"], [0.01, 0.5])
    np.testing.assert_allclose(plant.drive["viscous"], [0.2, 0.0])


@pytest.mark.parametrize("floating", [False, True])
def test_the_audit_holds_it_against_mujocos_own_model(floating: bool, tmp_path: Path) -> None:
    path = scenario(tmp_path).parent / "arm.xml"
    if floating:
        path.write_text(ARM.replace('<body name="base">', '<body name="base"><freejoint/>'))
    rows = [row for row in audit(path, ["mujoco"]).rows if row.property.startswith("file as read")]
    assert [row.verdict for row in rows] == ["passed", "passed"]
    assert all("MuJoCo's own" in row.note for row in rows)
