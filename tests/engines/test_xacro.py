"""xacro in: the macros of a robot's file are expanded where the package is installed, and a sentence where not."""

from dataclasses import replace
from pathlib import Path

import pytest
from realitygap.diagnose.result.revised_urdf import revised_urdf
from realitygap_engines.errors import ModelError
from realitygap_engines.model.read import read_model
from realitygap_engines.model.xacro_file import is_xacro

ROBOT = """<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:arg name="mass" default="1.5"/>
<xacro:include filename="$(find r_description)/link.xacro"/><xacro:body name="base"/><xacro:body name="arm"/>
<joint name="hinge" type="continuous"><parent link="base"/><child link="arm"/><axis xyz="0 1 0"/></joint></robot>"""
LINK = """<robot xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:macro name="body" params="name">
<link name="${name}"><inertial><mass value="${2 * $(arg mass)}"/>
<inertia ixx="0.02" iyy="0.03" izz="0.04" ixy="0" ixz="0" iyz="0"/></inertial>
</link></xacro:macro></robot>"""


@pytest.fixture
def robot(tmp_path: Path) -> Path:
    (tmp_path / "src" / "somewhere").mkdir(parents=True)
    (tmp_path / "src" / "somewhere" / "link.xacro").write_text(LINK)
    path = tmp_path / "robot.urdf.xacro"
    path.write_text(ROBOT)
    return path


def test_macros_arguments_and_packages_are_expanded(robot: Path) -> None:
    pytest.importorskip("xacro")
    model = read_model(robot, floating=False, packages={"r_description": robot.parent / "src" / "somewhere"})
    assert (model.joint_names, model.links[1].mass) == (["hinge"], 3.0)
    (robot.parent / "src" / "somewhere").rename(robot.parent / "r_description")  # and beside the file
    assert read_model(robot, floating=False).links[1].mass == 3.0


def test_expressions_without_macros_make_a_xacro_too_whatever_it_is_called(tmp_path: Path) -> None:
    pytest.importorskip("xacro")
    link = '<link name="{}"><inertial><mass value="{}"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'
    robot = f"""<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">{link.format("a", "${2 * 1.5}")}</inertial>
</link><!-- {link.format("b", "${mass}")} --></robot>"""
    path = tmp_path / "robot.urdf"
    path.write_text(robot)
    assert read_model(path, floating=True).mass == 3.0
    path.write_text(robot.replace("2 * 1.5", "mass"))
    with pytest.raises(
        ModelError, match=r"is a xacro file that cannot be .*'mass' is not defined.*expand it first: xacro"
    ):
        read_model(path, floating=True)
    path.write_text(robot.replace("${2 * 1.5}", "3"))  # what is left of an expanded file
    assert not is_xacro(path, path.read_bytes())
    assert read_model(path, floating=True).mass == 3.0


def test_what_cannot_be_expanded_is_one_sentence(robot: Path) -> None:
    pytest.importorskip("xacro")
    with pytest.raises(ModelError, match=r"robot.urdf.xacro: package r_description was not found; say") as e:
        read_model(robot, floating=False)
    assert str(e.value).count("r_description") == 1
    assert "a scenario does under robot: packages:, and `init`, which writes" in str(e.value)
    assert str(e.value).endswith("takes --package NAME=DIR")
    robot.write_text(ROBOT.replace("$(find r_description)/link.xacro", "${nothing}"))
    with pytest.raises(ModelError, match=r"cannot be expanded .*'nothing' is not defined") as e:
        read_model(robot, floating=False)
    assert "\n" not in str(e.value)


@pytest.mark.parametrize(
    ("name", "target"),
    [
        ("robot.urdf.xacro", "robot.urdf"),
        ("robot.xacro", "robot.urdf"),
        ("robot.v2.urdf.xacro", "robot.v2.urdf"),
        ("robot.urdf", "robot_expanded.urdf"),
    ],
)
def test_what_is_told_to_type_writes_over_no_source(name: str, target: str, tmp_path: Path) -> None:
    """A shell empties the file behind `>` before xacro reads it."""
    (tmp_path / name).write_text(ROBOT.replace("$(find r_description)/link.xacro", "${nothing}"))
    with pytest.raises(ModelError, match=f"expand it first: xacro {name} > {target}($| )"):
        read_model(tmp_path / name, floating=False)


def test_without_the_package_the_sentence_says_how(robot: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda _: None)
    with pytest.raises(ModelError, match=r"robot.urdf.xacro: is a xacro file, not a URDF; expand it first: .*pip"):
        read_model(robot, floating=False)


def test_a_mended_xacro_is_the_expanded_file(robot: Path, tmp_path: Path) -> None:
    pytest.importorskip("xacro")
    packages = {"r_description": robot.parent / "src" / "somewhere"}
    model = read_model(robot, floating=False, packages=packages)
    mended = tmp_path / "mended.urdf"
    mended.write_text(revised_urdf(robot, tmp_path, [replace(model.links[1], mass=7.0)], packages))
    assert read_model(mended, floating=False).links[1].mass == 7.0
