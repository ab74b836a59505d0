"""Mended models go out in the format they came in: for every effect, a URDF, a SDF and a MJCF that are read back move
as the changed model did; what the format cannot say stands beside it, in the scenario.
"""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from realitygap.diagnose.result.revise import BODY
from realitygap.robot.effects import EFFECTS, Effect
from realitygap.robot.plant import build_plant
from realitygap.scenario.file import load_scenario
from realitygap.simulate.effect_bench import command
from realitygap_engines.model.read import format_of, read_model
from revised import assert_same, mended

FEET = [(x, y) for x in (-0.1, 0.1) for y in (-0.1, 0.1)]


def urdf() -> str:
    """A cart on four round feet that carries a pendulum with a bob screwed on."""
    feet = "".join(
        f'<collision><origin xyz="{x} {y} -0.04"/><geometry><sphere radius="0.01"/></geometry></collision>'
        for x, y in FEET
    )

    def inertial(mass: float, z: float, size: float) -> str:
        return (
            f'<inertial><origin xyz="0.01 0 {z}" rpy="0.2 0 0"/><mass value="{mass}"/><inertia ixx="{size}" '
            f'iyy="{1.5 * size}" izz="{2 * size}" ixy="0" ixz="0" iyz="0"/></inertial>'
        )

    return f"""<robot name="cart"><!-- weighed on a kitchen scale -->
<link name="base">{inertial(1.0, 0, 4e-3)}{feet}</link><link name="arm">{inertial(0.3, -0.1, 1e-3)}</link>
<link name="bob">{inertial(0.2, 0, 2e-4)}</link>
<joint name="hinge" type="revolute"><parent link="base"/><child link="arm"/><origin xyz="0 0 0.3" rpy="0 0 0.1"/>
<axis xyz="0 1 0"/><limit lower="-3" upper="3" effort="50" velocity="50"/><dynamics damping="0.02" friction="0.05"/>
</joint><joint name="screw" type="fixed"><parent link="arm"/><child link="bob"/><origin xyz="0 0 -0.15"/></joint>
</robot>"""


def sdf() -> str:
    """The same."""
    feet = "".join(
        f'<collision name="foot_{i}"><pose>{x} {y} -0.04 0 0 0</pose><geometry><sphere><radius>0.01</radius></sphere>'
        "</geometry></collision>"
        for i, (x, y) in enumerate(FEET)
    )

    def inertial(mass: float, z: float, size: float) -> str:
        return (
            f"<inertial><pose>0.01 0 {z} 0.2 0 0</pose><mass>{mass}</mass><inertia><ixx>{size}</ixx><iyy>{1.5 * size}"
            f"</iyy><izz>{2 * size}</izz><ixy>0</ixy><ixz>0</ixz><iyz>0</iyz></inertia></inertial>"
        )

    return f"""<sdf version="1.9"><model name="cart"><!-- weighed on a kitchen scale -->
<link name="base">{inertial(1.0, 0, 4e-3)}{feet}</link>
<link name="arm"><pose relative_to="base">0 0 0.3 0 0 0.1</pose>{inertial(0.3, -0.1, 1e-3)}</link>
<link name="bob"><pose relative_to="arm">0 0 -0.15 0 0 0</pose>{inertial(0.2, 0, 2e-4)}</link>
<joint name="hinge" type="revolute"><parent>base</parent><child>arm</child><axis><xyz>0 1 0</xyz><limit>
<lower>-3</lower><upper>3</upper><effort>50</effort><velocity>50</velocity></limit><dynamics><damping>0.02</damping>
<friction>0.05</friction></dynamics></axis></joint>
<joint name="screw" type="fixed"><parent>arm</parent><child>bob</child></joint></model></sdf>"""


def mjcf() -> str:
    """The same."""
    feet = "".join(f'<geom type="sphere" size="0.01" pos="{x} {y} -0.04" mass="0"/>' for x, y in FEET)

    def inertial(mass: float, z: float, size: float) -> str:
        return (
            f'<inertial pos="0.01 0 {z}" euler="0.2 0 0" mass="{mass}" diaginertia="{size} {1.5 * size} {2 * size}"/>'
        )

    return f"""<mujoco model="cart"><!-- weighed on a kitchen scale --><compiler angle="radian" balanceinertia="false"/>
<worldbody><body name="base"><freejoint/>{inertial(1.0, 0, 4e-3)}{feet}<body name="arm" pos="0 0 0.3" euler="0 0 0.1">
<joint name="hinge" axis="0 1 0" range="-3 3" damping="0.02" frictionloss="0.05" actuatorfrcrange="-50 50"/>
{inertial(0.3, -0.1, 1e-3)}<body name="bob" pos="0 0 -0.15">{inertial(0.2, 0, 2e-4)}</body></body></body></worldbody>
</mujoco>"""


ROBOTS = {"urdf": ("cart.urdf", urdf), "sdf": ("cart.sdf", sdf), "mjcf": ("cart.xml", mjcf)}
SERVO = {
    "joints": "*",
    "kind": "dc",
    "gain": 2.5,
    "duty_limit": 0.9625,
    "supply": 15.0,
    "torque_constant": 2.19,
    "resistance": 2.96,
    "armature": 0.0266,
    "friction": {"coulomb": 0.05, "viscous": 0.02},
}
PID_SERVO = {"joints": "*", "kind": "pid", "kp": 28.0, "kd": 1.0, "armature": 0.0266}


def team(folder: Path, form: str, *, on_the_ground: bool, servo: dict[str, Any] = SERVO, effort: str = "none") -> Path:
    """A scenario of the cart in a format: clamped, or on the ground; `effort` is what was measured of it."""
    name, text = ROBOTS[form]
    (folder / name).write_text(text())
    time = np.arange(0.0, 2.0, 0.01)
    goal = command(time)[:, 0]
    seen = np.interp(time - 0.05, time, goal)
    told = [
        "" if 0.6 < t < 0.8 else f"{c:.5f}" for t, c in zip(time, goal, strict=True)
    ]  # the servo is off for a while
    columns = zip(time, told, seen, np.gradient(seen, time), strict=True)
    rows = "".join(f"{t:.2f},{c},{q:.3f},{w:.2f},{0.1 * w:.3f}\n" for t, c, q, w in columns)
    (folder / "log.csv").write_text(f"time,command,position,velocity,effort\n{rows}")
    content = {
        "name": "cart",
        "robot": {"urdf": name, "base": "floating" if on_the_ground else "fixed"},
        "servos": [servo],
        "motion": {"recorded": "command"},
        "ground": {"friction": 0.5, "stiffness": 20_000, "damping": 200} if on_the_ground else "none",
        "physics": {"step_rate": 1000},
        "recordings": {"effort": effort, "runs": [{"path": "log.csv", "use": "train"}]},
    }
    path = folder / "scenario.yaml"
    path.write_text(yaml.safe_dump(content, sort_keys=False))
    return path


def skip_without(form: str) -> None:
    if form == "sdf":
        pytest.importorskip("pydrake")


@pytest.mark.parametrize("form", ROBOTS)
@pytest.mark.parametrize("effect", EFFECTS.values(), ids=list(EFFECTS))
def test_a_mended_model_moves_as_the_changed_one_in_every_format(effect: Effect, form: str, tmp_path: Path) -> None:
    skip_without(form)
    (tmp_path / "team").mkdir()
    servo = PID_SERVO if effect.name.startswith("derivative_") else SERVO
    effort = "motor" if effect.signals == ("effort",) else "none"  # else nothing shows it
    on_the_ground = effect.sits_at == "ground"
    scenario = team(tmp_path / "team", form, on_the_ground=on_the_ground, servo=servo, effort=effort)
    plant = build_plant(load_scenario(scenario))
    target, index = {"joint": ("hinge", 0), "link": ("arm", 1)}.get(effect.sits_at, (effect.sits_at, 0))
    values = effect.first_size(plant, index)
    problem, changes, revised = mended(scenario, [(effect.name, target, values)], tmp_path / "out")
    assert_same(problem, changes, revised)
    robot = revised.resolve(revised.scenario.robot.urdf, "robot.urdf")
    assert (format_of(robot), robot.suffix) == (form, (tmp_path / "team" / ROBOTS[form][0]).suffix)
    assert "kitchen scale" in robot.read_text()
    listed = [(e.effect, e.target) for e in revised.scenario.effects]
    assert listed == ([] if effect.name in BODY else [(effect.name, target)])
    floating = effect.sits_at == "ground"
    before, after = (read_model(p, floating=floating) for p in (tmp_path / "team" / ROBOTS[form][0], robot))
    moved = [
        b.name
        for b, a in zip(before.links, after.links, strict=True)
        if not np.isclose(a.mass, b.mass)
        or not np.allclose(a.com, b.com, atol=1e-9)
        or not np.allclose(a.inertia, b.inertia, atol=1e-9)
    ]
    assert moved == (["arm"] if effect.name in BODY else []), "what is not found stays as it was"


def test_the_three_formats_are_one_machine(tmp_path: Path) -> None:
    pytest.importorskip("pydrake")
    models = []
    for form, (name, text) in ROBOTS.items():
        (tmp_path / name).write_text(text())
        models.append(read_model(tmp_path / name, floating=True))
        assert format_of(tmp_path / name) == form
    for other in models[1:]:
        for ours, theirs in zip(models[0].links, other.links, strict=True):
            assert (ours.name, ours.merged) == (theirs.name, theirs.merged)
            assert ours.mass == pytest.approx(theirs.mass)
            np.testing.assert_allclose(ours.com, theirs.com, atol=1e-12)
            np.testing.assert_allclose(ours.inertia, theirs.inertia, atol=1e-12)
            assert len(ours.spheres) == len(theirs.spheres)
        mine, their = models[0].joints[0], other.joints[0]
        np.testing.assert_allclose(mine.origin, their.origin, atol=1e-12)
        assert (mine.lower, mine.upper, mine.effort, mine.friction, mine.damping) == (
            their.lower,
            their.upper,
            their.effort,
            their.friction,
            their.damping,
        )
