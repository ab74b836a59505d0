"""SDF in: the machine that Drake's parser reads, and one sentence for the rest."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh
from realitygap_engines.errors import ModelError
from realitygap_engines.law.dynamics import Dynamics
from realitygap_engines.model.read import read_model
from realitygap_engines.model.robot import Mimic, Sphere
from realitygap_engines.model.sdf_revised import revised_sdf

pytest.importorskip("pydrake")
INERTIAL = """<inertial><pose>0.1 0.02 -0.03 0.2 0.1 -0.3</pose><mass>1.5</mass><inertia><ixx>0.02</ixx><iyy>0.03</iyy>
<izz>0.04</izz><ixy>0.001</ixy><ixz>-0.002</ixz><iyz>0.003</iyz></inertia></inertial>"""
ROBOT = f"""<sdf version="1.9"><model name="r"><link name="base">{INERTIAL}</link>
<link name="camera"><pose relative_to="base">0.1 0 0.2 0.3 0 0</pose>{INERTIAL}</link>
<joint name="mount" type="fixed"><parent>base</parent><child>camera</child></joint>
<link name="arm"><pose relative_to="camera">0.3 -0.1 0.2 0.4 -0.5 0.6</pose>{INERTIAL}</link>
<joint name="elbow" type="revolute"><pose>0.01 0.02 0.03 0.1 0 0</pose><parent>camera</parent><child>arm</child>
<axis><xyz>0.6 0 0.8</xyz><limit><lower>-1</lower><upper>2</upper><effort>3</effort></limit>
<dynamics><damping>0.5</damping><friction>0.25</friction></dynamics></axis></joint>
<link name="hand"><pose relative_to="arm">0 0 0.2 0 0 0</pose>{INERTIAL}</link>
<joint name="rail" type="prismatic"><parent>arm</parent><child>hand</child><axis><xyz>0 1 0</xyz></axis></joint>
</model></sdf>"""


def written(folder: Path, text: str) -> Path:
    path = folder / "robot.sdf"
    path.write_text(text)
    return path


def test_inertia_and_gravity_are_drakes(tmp_path: Path) -> None:
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import MultibodyPlant

    path = written(tmp_path, ROBOT)
    model = read_model(path, floating=False)
    assert [link.merged for link in model.links] == [("base", "camera"), ("arm",), ("hand",)]
    plant = MultibodyPlant(0.0)
    Parser(plant).AddModels(str(path))
    plant.mutable_gravity_field().set_gravity_vector([0, 0, -9.81])
    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName("base"))
    plant.Finalize()
    context = plant.CreateDefaultContext()
    dynamics = Dynamics(model)
    for seed in range(3):
        q, w = np.random.default_rng(seed).uniform(-1, 1, (2, 2))
        plant.SetPositionsAndVelocities(context, np.append(q, w))
        bias = plant.CalcBiasTerm(context) - plant.CalcGravityGeneralizedForces(context)
        dynamics.update(q, w, np.array([0.0, 0, 0, 1, *np.zeros(9)]), np.array([0.0, 0, -9.81]))
        np.testing.assert_allclose(dynamics.inertia, plant.CalcMassMatrix(context), rtol=0, atol=1e-9)
        np.testing.assert_allclose(dynamics.bias, bias, rtol=0, atol=1e-9)


def test_what_a_joint_has(tmp_path: Path) -> None:
    elbow, rail = read_model(written(tmp_path, ROBOT), floating=True).joints
    assert (elbow.lower, elbow.upper, elbow.effort, elbow.damping, elbow.friction) == (-1, 2, 3, 0.5, 0.25)
    assert (rail.prismatic, rail.lower, rail.upper) == (True, -np.inf, np.inf)


ONE = f'<sdf version="1.9"><model name="r"><link name="base">{{}}{INERTIAL}</link></model></sdf>'
BOX = ("0.1 0 0.02", "0 0 0.5", "<box><size>0.1 0.2 0.3</size></box>", '<box size="0.1 0.2 0.3"/>')
CYLINDER = (
    *("0 0.1 0", "0 0.4 0", "<cylinder><radius>0.06</radius><length>0.1</length></cylinder>"),
    '<cylinder radius="0.06" length="0.1"/>',
)
BALL = ("0 0 -0.1", "0 0 0", "<sphere><radius>0.07</radius></sphere>", '<sphere radius="0.07"/>')
MESH = ("0 0 0.2", "0.3 0 0", "<mesh><uri>brick.stl</uri></mesh>", '<mesh filename="brick.stl"/>')


def placed(spheres: tuple[Sphere, ...]) -> set[tuple[float, ...]]:
    return {tuple(np.round([*s.center, s.radius], 9) + 0.0) for s in spheres}


@pytest.mark.parametrize("shapes", [(BOX, CYLINDER), (BALL,), (MESH,)], ids=["with corners", "a sphere", "a mesh"])
def test_shapes_touch_where_a_urdf_has_them(shapes: tuple[tuple[str, ...], ...], tmp_path: Path) -> None:
    trimesh.creation.box((0.1, 0.3, 0.05)).export(tmp_path / "brick.stl")
    ours = "".join(
        f'<collision name="{i}"><pose>{at} {turn}</pose><geometry>{shape}</geometry></collision>'
        for i, (at, turn, shape, _) in enumerate(shapes)
    )
    path = written(tmp_path, ONE.format(ours))
    (link,) = read_model(path, floating=True).links
    theirs = "".join(
        f'<collision><origin xyz="{at}" rpy="{turn}"/><geometry>{shape}</geometry></collision>'
        for at, turn, _, shape in shapes
    )
    urdf = tmp_path / "robot.urdf"
    inertial = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
    urdf.write_text(f'<robot name="r"><link name="base">{inertial}{theirs}</link></robot>')
    (expected,) = read_model(urdf, floating=True).links
    assert placed(link.spheres) == placed(expected.spheres)
    assert read_model(path, floating=True, contact_links=[]).links[0].spheres == ()


def test_a_capsule_has_two_ends(tmp_path: Path) -> None:
    capsule = "<capsule><radius>0.05</radius><length>0.2</length></capsule>"
    shape = f'<collision name="a"><pose>0 0 0.3 1 0 0</pose><geometry>{capsule}</geometry></collision>'
    path = written(tmp_path, ONE.format(shape))
    up = np.array([0.0, -np.sin(1.0), np.cos(1.0)])
    ends = tuple(Sphere(np.array([0.0, 0.0, 0.3]) + side * 0.1 * up, 0.05) for side in (-1, 1))
    assert placed(read_model(path, floating=True).links[0].spheres) == placed(ends)


def test_a_mesh_that_is_missing_matters_where_there_is_ground_only(tmp_path: Path) -> None:
    mesh = '<collision name="m"><geometry><mesh><uri>model://nowhere/x.stl</uri></mesh></geometry></collision>'
    path = written(tmp_path, ROBOT.replace('<link name="base">', f'<link name="base">{mesh}'))
    assert len(read_model(path, floating=False, contact_links=[]).joints) == 2
    with pytest.raises(ModelError, match=r"mesh package://nowhere/x\.stl of link base was not found"):
        read_model(path, floating=False)


def test_a_mimic_counts_from_its_reference(tmp_path: Path) -> None:
    said = "<multiplier>-2</multiplier><offset>0.5</offset><reference>0.1</reference>"
    mimic = f'<xyz>0 1 0</xyz><mimic joint="elbow">{said}</mimic>'
    text = ROBOT.replace("<xyz>0 1 0</xyz>", mimic).replace("1.9", "1.11")
    elbow, rail = read_model(written(tmp_path, text), floating=False).joints
    assert elbow.mimic is None
    assert rail.mimic == Mimic("elbow", -2.0, 0.5 + 2 * 0.1)


BAD = {
    "a shape without size": (
        ROBOT.replace(
            '<link name="base">', '<link name="base"><collision name="c"><geometry><box/></geometry></collision>'
        ),
        "size of a box: found nothing, expected 3 numbers",
    ),
    "a mimic of nothing": (
        ROBOT.replace("<xyz>0 1 0</xyz>", '<xyz>0 1 0</xyz><mimic joint="knee"/>').replace("1.9", "1.11"),
        "knee",
    ),
    "not well-formed": ("<sdf><model>", "robot.sdf: is not"),
    "a ball joint": (ROBOT.replace('type="prismatic"', 'type="ball"'), "joint rail is ball_rpy; expected revolute"),
    "no model": ('<sdf version="1.9"></sdf>', "robot.sdf: "),
}


@pytest.mark.parametrize("case", BAD)
def test_what_cannot_be_simulated_is_one_sentence(case: str, tmp_path: Path) -> None:
    text, sentence = BAD[case]
    with pytest.raises(ModelError) as error:
        read_model(written(tmp_path, text), floating=False)
    assert sentence in str(error.value)
    assert "\n" not in str(error.value)


def test_a_mended_link_is_read_again_as_it_was_found(tmp_path: Path) -> None:
    path = written(tmp_path, ROBOT)
    model = read_model(path, floating=True)
    inertia = np.array([[0.05, 0.001, 0.0], [0.001, 0.04, 0.002], [0.0, 0.002, 0.06]])
    mended = [replace(x, mass=2.25, com=np.array([0.1, 0.02, -0.3]), inertia=inertia) for x in model.links[:2]]
    path.write_text(revised_sdf(path, tmp_path, mended))
    again = read_model(path, floating=True)
    for link, found in zip(again.links[:2], mended, strict=True):
        assert link.mass == pytest.approx(found.mass, rel=1e-9)
        np.testing.assert_allclose(link.com, found.com, rtol=0, atol=1e-9)
        np.testing.assert_allclose(link.inertia, found.inertia, rtol=0, atol=1e-9)
