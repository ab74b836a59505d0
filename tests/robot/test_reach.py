"""Which joints carry which."""

from pathlib import Path

from realitygap.robot.reach import chain
from realitygap_engines.model.read import read_model

FORKED = """<robot name="forked">
  <link name="base"/>
  {links}
  <joint name="hip" type="revolute"><parent link="base"/><child link="thigh"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1" effort="9" velocity="9"/></joint>
  <joint name="arm" type="revolute"><parent link="base"/><child link="hand"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1" effort="9" velocity="9"/></joint>
  <joint name="knee" type="revolute"><parent link="thigh"/><child link="shank"/><axis xyz="0 1 0"/>
    <origin xyz="0 0 -0.4"/><limit lower="-1" upper="1" effort="9" velocity="9"/></joint>
</robot>"""
LINK = """<link name="{name}"><inertial><origin xyz="0 0 -0.1"/><mass value="1"/>
  <inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>"""


def test_a_joint_is_carried_by_those_before_it_and_by_no_other_branch(tmp_path: Path) -> None:
    urdf = tmp_path / "forked.urdf"
    urdf.write_text(FORKED.format(links="".join(LINK.format(name=n) for n in ("thigh", "hand", "shank"))))
    model = read_model(urdf, floating=False)
    hip, arm, knee = (model.joint_names.index(n) for n in ("hip", "arm", "knee"))
    assert chain(model, knee) == {hip, knee}
    assert chain(model, hip) == {hip}
    assert chain(model, arm) == {arm}
