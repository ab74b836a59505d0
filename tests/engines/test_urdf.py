"""URDF in: fixed joints lumped exactly, order kept, and one sentence for what no engine could simulate."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pinocchio
import pytest
from realitygap_engines.errors import ModelError
from realitygap_engines.model.read import read_model
from realitygap_engines.model.robot import link_poses
from realitygap_engines.model.urdf import read_urdf, write_urdf

INERTIA = '<inertia ixx="0.02" iyy="0.03" izz="0.04" ixy="0.001" ixz="-0.002" iyz="0.003"/>'
INERTIAL = f'<inertial><origin xyz="0.1 0.02 -0.03" rpy="0.2 0.1 -0.3"/><mass value="1.5"/>{INERTIA}</inertial>'
LIMIT = '<limit lower="-1" upper="2" effort="3" velocity="4"/>'


def link(name: str, content: str = INERTIAL) -> str:
    return f'<link name="{name}">{content}</link>'


def joint(name: str, parent: str, child: str, kind: str = "revolute", content: str = LIMIT) -> str:
    axis = '<axis xyz="0.6 0 0.8"/>' if kind != "fixed" else ""
    return (
        f'<joint name="{name}" type="{kind}"><origin xyz="0.3 -0.1 0.2" rpy="0.4 -0.5 0.6"/>'
        f'<parent link="{parent}"/><child link="{child}"/>{axis}{content}</joint>'
    )


def written(folder: Path, *parts: str, name: str = "robot.urdf") -> Path:
    path = folder / name
    path.write_text(f'<robot name="r">{"".join(parts)}</robot>')
    return path


TREE = (
    *(link(n) for n in ("base", "camera", "arm", "tool", "leg")),
    joint("camera_mount", "base", "camera", "fixed", ""),
    joint("elbow", "camera", "arm"),  # names in the order in which pinocchio sorts them
    joint("tool_mount", "arm", "tool", "fixed", ""),
    joint("hip", "base", "leg", "prismatic"),
)


@pytest.mark.parametrize("floating", [True, False])
def test_lumping_fixed_joints_is_exact(floating: bool, tmp_path: Path) -> None:
    """The mass matrix of the lumped tree, written and read again, is that of the whole one."""
    source = written(tmp_path, *TREE)
    model = read_urdf(source, floating=floating)
    again = tmp_path / "lumped.urdf"
    again.write_text(write_urdf(model))
    assert [body.merged for body in model.links] == [("base", "camera"), ("arm", "tool"), ("leg",)]
    assert model.joint_names == ["elbow", "hip"]
    free = (pinocchio.JointModelFreeFlyer(),) if floating else ()
    matrices, order = [], []
    for path in (source, again):
        oracle = pinocchio.buildModelFromUrdf(str(path), *free)
        q = pinocchio.integrate(oracle, pinocchio.neutral(oracle), np.linspace(0.1, 0.7, oracle.nv))
        matrices.append(pinocchio.crba(oracle, oracle.createData(), q))
        order.append(list(oracle.names))
    assert order[0] == order[1]
    np.testing.assert_allclose(matrices[1], matrices[0], rtol=0, atol=1e-12)


def test_link_poses_are_pinocchios(tmp_path: Path) -> None:
    path = written(tmp_path, *TREE)
    model = read_urdf(path, floating=False)
    oracle = pinocchio.buildModelFromUrdf(str(path))
    data = oracle.createData()
    position = np.array([0.7, -0.2])
    q = np.array([position[model.joint_names.index(n)] for n in list(oracle.names)[1:]])
    pinocchio.framesForwardKinematics(oracle, data, q)
    for body, pose in zip(model.links, link_poses(model, position), strict=True):
        expected = data.oMf[oracle.getFrameId(body.name)].homogeneous
        np.testing.assert_allclose(pose, expected, atol=1e-12)


def test_what_a_joint_has(tmp_path: Path) -> None:
    content = f'{LIMIT}<dynamics damping="0.5" friction="0.25"/>'
    path = written(tmp_path, link("base"), link("arm"), joint("shoulder", "base", "arm", "revolute", content))
    (shoulder,) = read_urdf(path, floating=False).joints
    assert (shoulder.lower, shoulder.upper, shoulder.effort, shoulder.velocity) == (-1, 2, 3, 4)
    assert (shoulder.damping, shoulder.friction, shoulder.armature, shoulder.prismatic) == (0.5, 0.25, 0.0, False)
    np.testing.assert_allclose(shoulder.axis, [0.6, 0.0, 0.8])


@pytest.mark.parametrize("kind", ["continuous", "revolute"])
def test_no_limit_is_no_limit_and_zero_effort_is_said(kind: str, tmp_path: Path) -> None:
    limit = '<limit effort="0" velocity="0"/>' if kind == "continuous" else ""
    path = written(tmp_path, link("base"), link("arm"), joint("shoulder", "base", "arm", kind, limit))
    model = read_urdf(path, floating=False)
    (shoulder,) = model.joints
    assert (shoulder.lower, shoulder.upper, shoulder.effort, shoulder.velocity) == (-np.inf, np.inf, np.inf, np.inf)
    assert len(model.notes) == (2 if limit else 0)


def test_a_base_without_mass_is_held_but_cannot_float(tmp_path: Path) -> None:
    path = written(tmp_path, link("world", ""), link("arm"), joint("shoulder", "world", "arm"))
    assert read_urdf(path, floating=False).joint_names == ["shoulder"]
    with pytest.raises(ModelError, match="link world moves but has no mass"):
        read_urdf(path, floating=True)


def test_what_is_dropped_may_be_anything(tmp_path: Path) -> None:
    """Visuals, materials, transmissions and extensions are not read, so nothing in them can be wrong."""
    path = written(
        tmp_path,
        "<!-- made by xacro: -->",
        link("base", f'{INERTIAL}<visual><origin xyz="a b"/><geometry><mesh/></geometry></visual>'),
        '<material name="m"><color rgba="x"/></material><transmission/><gazebo reference="none"><mass/></gazebo>',
    )
    assert read_urdf(path, floating=True).mass == 1.5


def test_a_long_chain_is_no_deep_recursion(tmp_path: Path) -> None:
    names = [f"l{i}" for i in range(1500)]
    joints = [joint(f"j{i}", a, b) for i, (a, b) in enumerate(pairwise(names))]
    assert len(read_urdf(written(tmp_path, *map(link, names), *joints), floating=True).joints) == 1499


def test_only_links_that_are_named_touch_the_ground(tmp_path: Path) -> None:
    ball = f'{INERTIAL}<collision><geometry><sphere radius="0.1"/></geometry></collision>'
    path = written(
        tmp_path,
        *(link(n, ball) for n in ("base", "arm", "hand")),
        joint("a", "base", "arm"),
        joint("b", "arm", "hand"),
    )

    def touching(names: list[str] | None) -> list[str]:
        return [x.name for x in read_urdf(path, floating=True, contact_links=names).links if x.spheres]

    assert touching(None) == ["base", "hand"]
    assert touching(["arm"]) == ["arm"]
    assert touching([]) == []
    with pytest.raises(ModelError, match="has no link foot that could touch the ground; it has base, arm, hand"):
        touching(["foot"])


def inertial(**values: float) -> str:
    tensor = {"ixx": 0.1, "iyy": 0.1, "izz": 0.1, "ixy": 0.0, "ixz": 0.0, "iyz": 0.0} | values
    attributes = " ".join(f'{k}="{v}"' for k, v in tensor.items())
    return f'<inertial><mass value="1"/><inertia {attributes}/></inertial>'


ARM = (link("base"), link("arm"))
HINGE = joint("shoulder", "base", "arm")
BAD = {
    "mass not a number": ((link("base", INERTIAL.replace("1.5", "heavy")),), "link base: mass value is 'heavy'"),
    "mass nan": ((link("base", INERTIAL.replace("1.5", "nan")),), "link base: mass value is 'nan'"),
    "mass infinite": ((link("base", INERTIAL.replace("1.5", "inf")),), "expected a finite number"),
    "effort negative": (
        (link("base"), link("arm"), HINGE.replace("</joint>", '<limit effort="-6" velocity="1"/></joint>')),
        "limit effort is '-6', expected no negative number",
    ),
    "mass negative": ((link("base", INERTIAL.replace("1.5", "-1")),), "expected no negative number"),
    "no mass value": ((link("base", INERTIAL.replace('value="1.5"', "")),), "mass has no value"),
    "no ixx": ((link("base", INERTIAL.replace('ixx="0.02"', "")),), "inertia has no ixx"),
    "inertia not positive": ((link("base", inertial(ixx=-0.1)),), "link base has principal moments of inertia -0.1"),
    "inertia against the triangle rule": (
        (link("base", inertial(ixx=0.5)),),
        "none larger than the other two together",
    ),
    "inertia off the diagonal": ((link("base", inertial(ixy=0.5)),), "which no body has"),
    "inertia nan": ((link("base", inertial(ixy=float("nan"))),), "inertia ixy is 'nan'"),
    "two numbers": ((link("base", INERTIAL.replace("0.1 0.02 -0.03", "0.1 0.02")),), "expected 3 finite numbers"),
    "origin nan": ((*ARM, HINGE.replace("0.3 -0.1 0.2", "nan 0 0")), "joint shoulder: origin xyz is 'nan 0 0'"),
    "limit nan": ((*ARM, HINGE.replace('lower="-1"', 'lower="nan"')), "limit lower is 'nan'"),
    "limits crossed": ((*ARM, HINGE.replace('lower="-1"', 'lower="3"')), "lower limit 3 above its upper limit 2"),
    "axis with commas": (
        (*ARM, HINGE.replace("0.6 0 0.8", "0.6,0,0.8")),
        "joint shoulder: axis xyz is '0.6,0,0.8', expected 3 finite numbers with spaces between them",
    ),
    "axis of zeros": ((*ARM, HINGE.replace("0.6 0 0.8", "0 0 0")), "expected a direction"),
    "damping negative": (
        (*ARM, joint("shoulder", "base", "arm", "revolute", '<dynamics damping="-1"/>')),
        "dynamics damping is '-1'",
    ),
    "box of no size": (
        (link("base", f'{INERTIAL}<collision><geometry><box size="1 0 1"/></geometry></collision>'),),
        "box size is '1 0 1', expected more than 0 m",
    ),
    "no link": ((), "has no link"),
    "no name": (("<link/>",), "a link has no name"),
    "no child": ((*ARM, HINGE.replace('<child link="arm"/>', "")), "joint shoulder has no child"),
    "unknown link": (
        (*ARM, HINGE.replace('child link="arm"', 'child link="leg"')),
        "names link leg, which is not defined",
    ),
    "link twice": ((link("base"), link("base")), "link base is defined 2 times"),
    "joint twice": ((*ARM, link("leg"), HINGE, HINGE.replace('"arm"', '"leg"')), "joint shoulder is defined 2 times"),
    "two parents": ((*ARM, HINGE, joint("other", "base", "arm")), "link arm has two parent joints"),
    "two roots": (ARM, "expected one root link, found arm, base"),
    "a loop": ((*ARM, HINGE, joint("back", "arm", "base")), "expected one root link, found none (a loop)"),
    "a loop beside": (
        (*ARM, link("root"), HINGE, joint("back", "arm", "base")),
        "link arm is in a loop of joints; expected a tree",
    ),
    "planar joint": ((*ARM, joint("slide", "base", "arm", "planar")), "is planar; expected one of revolute"),
    "no type": ((*ARM, HINGE.replace('type="revolute"', "")), "joint shoulder is of no type; expected one of"),
    "mimic of nothing": (
        (*ARM, joint("m", "base", "arm", content=f'{LIMIT}<mimic joint="shoulder"/>')),
        "joint m mimics shoulder; expected one of the moving joints m",
    ),
    "mimic in a circle": ((*ARM, joint("m", "base", "arm", content=f'{LIMIT}<mimic joint="m"/>')), "mimics itself"),
    "mimic that does not move": (
        (*ARM, link("leg"), HINGE, joint("m", "base", "leg", content='<mimic joint="shoulder" multiplier="0"/>')),
        "joint m mimics shoulder 0 times",
    ),
    "no mass at all": ((link("base", ""),), "link base moves but has no mass"),
    "moving link without mass": ((link("base"), link("arm", ""), HINGE), "link arm moves but has no mass"),
}


@pytest.mark.parametrize("case", BAD)
def test_what_cannot_be_simulated_is_one_sentence(case: str, tmp_path: Path) -> None:
    parts, sentence = BAD[case]
    path = written(tmp_path, *parts)
    with pytest.raises(ModelError) as error:
        read_urdf(path, floating=True)
    assert str(error.value).startswith(f"{path}: ")
    assert sentence in str(error.value)
    assert "\n" not in str(error.value)


def test_a_robot_that_cannot_move(tmp_path: Path) -> None:
    with pytest.raises(ModelError, match="nothing can move"):
        read_urdf(written(tmp_path, link("base")), floating=False)


BOMB = '<!DOCTYPE r [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;">]><robot name="&b;"/>'
OUTSIDE = '<!DOCTYPE r [<!ENTITY a SYSTEM "file:///etc/hostname">]><robot name="&a;"/>'
FILES = {
    "empty": (b"", "is not well-formed XML"),
    "not XML": (b"solid mesh", "is not well-formed XML"),
    "cut off": (b'<robot name="r"><link name="a">', "is not well-formed XML"),
    "binary": (bytes(range(256)), "is not well-formed XML"),
    "unknown encoding": (b'<?xml version="1.0" encoding="klingon"?><robot/>', "is not well-formed XML"),
    "another root": (b"<sdf/>", "the root element is <sdf>, expected <robot>"),
    "entity bomb": (BOMB.encode(), "found XML entities"),
    "external entity": (OUTSIDE.encode(), "found XML entities"),
    "xacro": (
        b'<robot xmlns:xacro="x"><xacro:include filename="a"/></robot>',
        "is a xacro file",
    ),
}


@pytest.mark.parametrize("case", FILES)
def test_files_that_are_no_urdf(case: str, tmp_path: Path) -> None:
    content, sentence = FILES[case]
    path = tmp_path / "robot.urdf"
    path.write_bytes(content)
    with pytest.raises(ModelError) as error:
        read_urdf(path, floating=True)
    assert str(error.value).startswith(f"{path}: ")
    assert sentence in str(error.value)


@pytest.mark.parametrize(
    ("name", "begin", "one"),
    [
        ("r.urdf", '<robot name="r">', '<link name="a"/>'),
        ("r.xml", "<mujoco><worldbody>", "<body/>"),
        ("r.sdf", '<sdf version="1.9"><model name="r">', '<link name="a"/>'),
    ],
)
def test_a_file_with_more_in_it_than_any_machine_is_told(name: str, begin: str, one: str, tmp_path: Path) -> None:
    path = tmp_path / name
    path.write_text(begin + one * 2_000_000)
    with pytest.raises(ModelError, match=f"{name}: holds .* tags, expected at most 20000"):
        read_model(path, floating=True)


@pytest.mark.parametrize(("name", "sentence"), [("none.urdf", "No such file"), (".", "Is a directory")])
def test_no_file(name: str, sentence: str, tmp_path: Path) -> None:
    with pytest.raises(ModelError, match=sentence):
        read_urdf(tmp_path / name, floating=True)
