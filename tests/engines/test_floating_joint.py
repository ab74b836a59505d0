"""A floating joint of a URDF says that its child is the base; in the middle of a robot it is refused."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from realitygap.init.draft import init
from realitygap.scenario.file import load_scenario
from realitygap_engines.errors import ModelError
from realitygap_engines.model.read import read_model
from realitygap_engines.model.robot import Model

INERTIAL = '<inertial><mass value="2"/><inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>'
ORIGIN = '<origin xyz="0.3 0 0.5" rpy="0.4 0 0"/>'
BODY = f'<link name="trunk">{INERTIAL}</link><link name="arm">{INERTIAL}</link>'
HINGE = (
    '<joint name="hinge" type="revolute"><parent link="trunk"/><child link="arm"/><axis xyz="0 1 0"/>'
    '<limit lower="-1" upper="1" effort="3" velocity="4"/></joint>'
)


def above(kind: str, root: str = '<link name="world"/>', parent: str = "world", child: str = "trunk") -> str:
    return f'{root}<joint name="free" type="{kind}">{ORIGIN}<parent link="{parent}"/><child link="{child}"/></joint>'


def model(folder: Path, *parts: str, floating: bool = True) -> Model:
    path = folder / "robot.urdf"
    path.write_text(f'<robot name="r">{"".join(parts)}</robot>')
    return replace(read_model(path, floating=floating), notes=())


def same(one: Model, other: Model) -> None:
    assert [(a.name, a.merged, a.mass) for a in one.links] == [(b.name, b.merged, b.mass) for b in other.links]
    for a, b in zip(one.links, other.links, strict=True):
        np.testing.assert_array_equal(a.com, b.com)
    for c, d in zip(one.joints, other.joints, strict=True):
        assert (c.name, c.parent) == (d.name, d.parent)
        np.testing.assert_array_equal(c.origin, d.origin)


def test_its_child_is_the_base(tmp_path: Path) -> None:
    same(model(tmp_path, above("floating"), BODY, HINGE), model(tmp_path, BODY, HINGE))
    alone = f'<link name="trunk">{INERTIAL}</link>'
    same(model(tmp_path, above("floating"), alone), model(tmp_path, alone))


def test_on_a_fixed_base_it_is_held_where_it_stands(tmp_path: Path) -> None:
    held = model(tmp_path, above("floating"), BODY, HINGE, floating=False)
    same(held, model(tmp_path, above("fixed"), BODY, HINGE, floating=False))


@pytest.mark.parametrize(
    ("parts", "found"),
    [
        ((BODY, HINGE, above("floating", '<link name="hand"/>', "arm", "hand")), "hangs on link arm; expected it betw"),
        ((BODY, HINGE, above("floating", f'<link name="world">{INERTIAL}</link>')), "has a mass or a shape of its own"),
        (
            (above("floating"), BODY, HINGE.replace('parent link="trunk"', 'parent link="world"')),
            "hangs on the root link world beside joint hinge",
        ),
    ],
)
def test_elsewhere_it_is_told_where_it_hangs(parts: tuple[str, ...], found: str, tmp_path: Path) -> None:
    with pytest.raises(ModelError, match=rf"joint free is floating and .*{found}.*make it one of revolute"):
        model(tmp_path, *parts)


def test_a_first_scenario_takes_the_base_for_floating(tmp_path: Path) -> None:
    (tmp_path / "robot.urdf").write_text(f'<robot name="r">{above("floating")}{BODY}{HINGE}</robot>')
    clock = np.arange(100) * 0.01
    pd.DataFrame({"time": clock, "hinge_pos": np.sin(clock), "hinge_goal": np.sin(clock)}).to_csv(
        tmp_path / "run.csv", index=False
    )
    draft = init(tmp_path / "robot.urdf", [tmp_path / "run.csv"], tmp_path / "out")
    assert load_scenario(draft.path).scenario.robot.base == "floating"
    assert any("the URDF has a floating joint above the link trunk" in line for line in draft.guessed)
