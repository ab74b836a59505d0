"""Inertias that no such link has: of a disc on its own axis, of which nothing lies aside, its mass tells the size."""

from pathlib import Path

import pytest
from realitygap.check.links import link_mistakes
from realitygap.robot.plant import build_plant
from realitygap.scenario.file import load_scenario

URDF = """<robot name="table"><link name="base"/>
<link name="disc"><inertial><origin xyz="0 0 0.02"/><mass value="{mass}"/>
<inertia ixx="{across}" ixy="0" ixz="0" iyy="{across}" iyz="0" izz="{along}"/></inertial></link>
<joint name="turn" type="revolute"><parent link="base"/><child link="disc"/><axis xyz="0 0 1"/>
<limit lower="-3" upper="3" effort="12" velocity="60"/></joint></robot>"""


def disc(folder: Path, mass: float, radius: float, times: float) -> list[str]:
    """What is said of a disc's link [kg, m], its inertia in a unit that is so many times too small."""
    along = 0.5 * mass * radius**2 * times
    text = URDF.format(mass=mass, across=0.55 * along, along=along)
    (folder / "table.urdf").write_text(text, encoding="utf-8")
    (folder / "sines.csv").write_text("time\n0\n", encoding="utf-8")
    scenario = "name: table\nrobot: {urdf: table.urdf, base: fixed}\nmotion: {followed: true}\nrecordings:\n"
    scenario += "  {virtual: true, effort: motor, runs: [{path: sines.csv, use: train}]}\n"
    (folder / "scenario.yaml").write_text(scenario, encoding="utf-8")
    found = link_mistakes(build_plant(load_scenario(folder / "scenario.yaml")))
    return [f"{m.kind}, {m.certainty}" for m in found]


@pytest.mark.parametrize(("mass", "radius"), [(4.0, 0.175), (0.05, 0.03), (30.0, 0.6)])
def test_a_disc_on_its_axis_is_told_only_where_its_inertia_is_in_another_unit(
    tmp_path: Path, mass: float, radius: float
) -> None:
    """As 0.5·m·r² in kg·m²; and in kg·mm², which puts the mass a thousand times further out."""
    assert disc(tmp_path, mass, radius, 1.0) == []
    assert disc(tmp_path, mass, radius, 1e6) == ["impossible_link, certain"]
