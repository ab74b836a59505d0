"""A mended MJCF: other inertials and the rest as it was, in another folder, with what it includes and its meshes."""

from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest
from realitygap.cli.main import main
from realitygap.diagnose.result.revised_urdf import revised_urdf
from realitygap.robot.mjcf_file import write_scenario_mjcf
from realitygap_engines.model.mjcf import read_mjcf
from realitygap_engines.model.mjcf_revised import revised_mjcf

INERTIAL = '<inertial pos=".01 0 -.1" mass="1.5" diaginertia=".02 .03 .04"/>'
LEG = f"""<mujocoinclude><body name="leg" pos="0 .1 0"><joint name="hip" axis="0 1 0" pos=".02 0 .03"/>{INERTIAL}
<body name="foot" pos="0 0 -.2"><geom type="mesh" mesh="m" mass=".3"/></body></body></mujocoinclude>"""
ROBOT = f"""<mujoco model="r"><!-- kept --><compiler meshdir="meshes"/><asset><mesh name="m" file="m.obj"/></asset>
<worldbody><body name="base">{INERTIAL}<include file="leg.xml"/></body></worldbody></mujoco>"""
MESH = "v 0 0 0\nv .3 0 0\nv 0 .2 0\nv 0 0 .5\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"


@pytest.fixture
def robot(tmp_path: Path) -> Path:
    folder = tmp_path / "robot"
    (folder / "meshes").mkdir(parents=True)
    (folder / "meshes" / "m.obj").write_text(MESH)
    (folder / "leg.xml").write_text(LEG)
    (folder / "robot.xml").write_text(ROBOT)
    return folder / "robot.xml"


def test_a_mended_link_is_read_again_as_it_was_found(robot: Path, tmp_path: Path) -> None:
    model = read_mjcf(robot, floating=False)
    inertia = np.array([[0.05, 0.001, 0.0], [0.001, 0.04, 0.002], [0.0, 0.002, 0.06]])
    mended = replace(model.links[1], mass=2.345678901234567, com=np.array([0.1, 0.02, -0.3]), inertia=inertia)
    out = tmp_path / "out" / "revised"
    out.mkdir(parents=True)
    path = out / "robot.xml"
    path.write_text(revised_urdf(robot, out, [mended]))
    assert "kept" in path.read_text()
    again = read_mjcf(path, floating=False)
    link = again.links[1]
    assert (again.joint_names, link.merged, link.mass) == (["hip"], ("leg", "foot"), mended.mass)
    np.testing.assert_allclose(link.com, mended.com, rtol=0, atol=1e-12)
    np.testing.assert_allclose(link.inertia, mended.inertia, rtol=0, atol=1e-12)
    np.testing.assert_allclose([s.center for s in link.spheres], [s.center for s in model.links[1].spheres], atol=1e-12)


@pytest.mark.parametrize("setting", ['inertiafromgeom="true"', 'settotalmass="5"'])
def test_a_mended_link_stays_where_the_file_computes_the_others(setting: str, robot: Path, tmp_path: Path) -> None:
    robot.write_text(ROBOT.replace("<compiler ", f"<compiler {setting} ").replace("</body>", "</body>"))
    if "geom" in setting:
        robot.write_text(robot.read_text().replace(INERTIAL, '<geom size=".1" mass="1.1"/>'))
        (robot.parent / "leg.xml").write_text(LEG.replace(INERTIAL, '<geom size=".1" pos=".1 .2 0" mass="1.2"/>'))
    model = read_mjcf(robot, floating=True)
    mended = replace(model.links[1], mass=3.5)
    path = tmp_path / "robot.xml"
    path.write_text(revised_mjcf(robot, tmp_path, [mended]))
    again = read_mjcf(path, floating=True)
    assert again.links[1].mass == 3.5
    assert again.links[0].mass == pytest.approx(model.links[0].mass, rel=1e-12)
    np.testing.assert_allclose(again.links[0].inertia, model.links[0].inertia, rtol=0, atol=1e-12)


DEMO = Path(__file__).parents[2] / "scenarios" / "demo" / "scenario.yaml"


def test_a_scenario_is_written_as_a_mjcf_that_loads_and_says_what_is_lost(tmp_path: Path) -> None:
    said = write_scenario_mjcf(DEMO, tmp_path / "robot.mjcf.xml")
    assert said == [f"mjcf: {tmp_path / 'robot.mjcf.xml'}", said[1]]
    assert "what differs in the runs steps_1.mcap, sines_2.mcap" in said[1]
    m = mujoco.MjModel.from_xml_path(str(tmp_path / "robot.mjcf.xml"))
    kt, resistance, gain, supply = 2.407, 2.62, 5.048, 15.0
    assert m.actuator_gainprm[0, 0] == pytest.approx(kt / resistance * gain * supply)
    assert m.dof_damping[0] == pytest.approx(kt * kt / resistance)
    assert m.dof_frictionloss[0] == 0.2756


def test_diagnose_has_the_option(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["diagnose", "--help"])
    assert "--mjcf" in capsys.readouterr().out
