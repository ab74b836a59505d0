"""MJCF in: the canonical model of a file is the machine that MuJoCo itself simulates, and one sentence for the rest."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
from realitygap_engines.engine import GRAVITY
from realitygap_engines.errors import ModelError
from realitygap_engines.law.dynamics import Dynamics
from realitygap_engines.model.mjcf import read_mjcf
from realitygap_engines.model.read import read_model
from realitygap_engines.model.robot import Model, rotation_from_quaternion

INERTIAL = '<inertial pos=".03 .01 -.02" quat=".9 .1 .2 .3" mass="1.5" diaginertia=".02 .03 .04"/>'
ARM = f"""<mujoco model="arm"><compiler angle="degree" autolimits="true"/>
<default><joint armature=".01" damping=".2" frictionloss=".05"/></default>
<worldbody><geom type="plane" size="1 1 .1"/>
<body name="base" pos=".1 .2 .3" euler="20 -30 40">{INERTIAL}
 <body name="plate" pos=".1 0 .05" euler="0 45 0">{INERTIAL}
  <body name="upper" pos=".05 .02 .1" euler="10 20 30">{INERTIAL}
   <joint name="shoulder" axis="1 2 3" pos=".02 -.03 .04" ref="25" range="-90 120"/>
   <body name="camera" pos=".2 0 0" euler="5 6 7"><geom type="box" size=".02 .03 .04" mass=".3" pos=".01 0 0"/>
   </body>
   <body name="slider" pos="0 .1 .2" euler="-20 0 15">{INERTIAL}
    <joint name="rail" type="slide" axis="0 1 1" pos=".3 .2 .1" ref=".05" range="-.1 .4" armature=".5"/>
    <body name="hand" pos=".1 .1 0"><joint name="wrist" axis="0 0 1"/><geom type="capsule" size=".03 .1" mass=".7"/>
    </body></body></body></body></body></worldbody></mujoco>"""
FLYER = ARM.replace('<body name="base"', '<body name="base"', 1).replace(
    'euler="20 -30 40">', 'euler="20 -30 40"><freejoint/>', 1
)


def written(folder: Path, text: str, name: str = "robot.xml") -> Path:
    path = folder / name
    path.write_text(text)
    return path


def native(path: Path, model: Model, seed: int) -> tuple[np.ndarray, ...]:
    """Joint positions, velocities and the base's row of a random state, with MuJoCo's own inertia and bias for it."""
    m = mujoco.MjModel.from_xml_path(str(path))
    m.opt.gravity[:] = 0, 0, -GRAVITY
    d = mujoco.MjData(m)
    rng = np.random.default_rng(seed)
    joints = [m.joint(name) for name in model.joint_names]
    q, w = rng.uniform(-1, 1, len(joints)), rng.uniform(-2, 2, len(joints))
    for joint, position, velocity in zip(joints, q, w, strict=True):
        d.qpos[joint.qposadr], d.qvel[joint.dofadr] = position, velocity
    base, turn = np.zeros(13), np.eye(m.nv)
    base[3] = 1.0
    dofs = [int(j.dofadr[0]) for j in joints]
    if model.floating:
        base[:] = rng.uniform(-1, 1, 13)
        base[3:7] /= np.linalg.norm(base[3:7])
        rotation = rotation_from_quaternion(base[3:7])
        d.qpos[:7], d.qvel[:3], d.qvel[3:6] = base[:7], base[7:10], rotation.T @ base[10:]
        turn[3:6, 3:6] = rotation
        dofs = [*range(6), *dofs]
    mujoco.mj_forward(m, d)
    inertia = np.zeros((m.nv, m.nv))
    mujoco.mj_fullM(m, d, inertia)
    own = np.zeros(m.nv)
    own[[int(j.dofadr[0]) for j in joints]] = model.armature
    inertia -= np.diag(own)
    return q, w, base, (turn @ inertia @ turn.T)[np.ix_(dofs, dofs)], (turn @ d.qfrc_bias)[dofs]


def assert_same_machine(path: Path, model: Model) -> None:
    dynamics = Dynamics(model)
    for seed in range(5):
        q, w, base, inertia, bias = native(path, model, seed)
        dynamics.update(q, w, base, np.array([0.0, 0.0, -GRAVITY]))
        np.testing.assert_allclose(dynamics.inertia, inertia, rtol=0, atol=1e-9)
        np.testing.assert_allclose(dynamics.bias, bias, rtol=0, atol=1e-9)


@pytest.mark.parametrize("text", [ARM, FLYER], ids=["fixed", "floating"])
def test_inertia_coriolis_and_gravity_are_mujocos(text: str, tmp_path: Path) -> None:
    """Whatever stands between joints is lumped exactly; joint positions, `ref` and default classes are followed."""
    path = written(tmp_path, text)
    model = read_mjcf(path, floating=text is FLYER)
    assert model.joint_names == ["shoulder", "rail", "wrist"]
    assert [link.merged for link in model.links] == [("base", "plate"), ("upper", "camera"), ("slider",), ("hand",)]
    assert_same_machine(path, model)


def test_so101_is_the_makers_own_urdf_and_mujocos_machine(data_dir: Path) -> None:
    """The two files of one maker: the same links and gravity within the digits that the files were written with."""
    folder = data_dir / "so101"
    model, urdf = (read_model(folder / name, floating=False) for name in ("so101.xml", "so101.urdf"))
    assert_same_machine(folder / "so101.xml", model)
    assert model.joint_names == urdf.joint_names
    gravity = np.array([0.0, 0.0, -GRAVITY])
    base, w = np.array([0, 0, 0, 1, *np.zeros(9)], dtype=float), np.zeros(6)
    for seed in range(3):
        q = np.random.default_rng(seed).uniform(-1, 1, 6)
        (a, b) = (Dynamics(model), Dynamics(urdf))
        a.update(q, w, base, gravity)
        b.update(q, w, base, gravity)
        np.testing.assert_allclose(a.inertia, b.inertia, rtol=0, atol=1e-6)
        np.testing.assert_allclose(a.bias, b.bias, rtol=0, atol=1e-5)
    elbow = model.joints[2]
    assert (elbow.armature, elbow.damping, elbow.friction, elbow.effort) == (0.028, 0.6, 0.052, 3.35)
    servo = model.actuators[2]
    assert servo.values["kv"] * servo.values["gain"] == pytest.approx(2.731)
    assert servo.values["kv"] * servo.values["gain"] * servo.values["kp"] == pytest.approx(998.22)


def test_what_a_joint_has(tmp_path: Path) -> None:
    shoulder, rail, wrist = read_mjcf(written(tmp_path, ARM), floating=False).joints
    assert (shoulder.lower, shoulder.upper) == pytest.approx((-np.pi / 2, np.pi * 2 / 3))
    assert (rail.lower, rail.upper, rail.armature, rail.prismatic) == (-0.1, 0.4, 0.5, True)
    assert (wrist.lower, wrist.upper, wrist.damping, wrist.friction) == (-np.inf, np.inf, 0.2, 0.05)


BAR = f'<body name="arm"><joint name="j"/>{INERTIAL}</body>'


def actuated(actuator: str) -> str:
    return f"<mujoco><worldbody>{BAR}</worldbody><actuator>{actuator}</actuator></mujoco>"


MOTOR = 'motorconst="1.5 1.5" resistance="2.5" input="pos"'
SERVOS = {
    '<position joint="j" kp="40" kv="2" gear="3" forcerange="-5 5"/>': ("cascade", 40 * 9, 2 * 9, 15),
    '<position joint="j" kp="40"/>': ("pid", 40, 0, np.inf),
    '<general joint="j" gainprm="40" biastype="affine" biasprm="0 -40 -2"/>': ("cascade", 40, 2, np.inf),
    '<pid joint="j" kp="40" kv="2" forcerange="-5 5"/>': ("pid", 40, 2, 5),
    '<velocity joint="j" kv="3" gear="2"/>': ("velocity", 0, 12, np.inf),
    '<motor joint="j" gear="2" ctrlrange="-4 4"/>': ("effort", 0, 0, 8),
    f'<dcmotor joint="j" {MOTOR} controller="40 0 0 0 0 12"/>': ("pid", 40, 0, np.inf),
    f'<dcmotor joint="j" {MOTOR.replace("pos", "voltage")} ctrlrange="-12 12"/>': ("dc", 0, 1.5**2 / 2.5, np.inf),
}


@pytest.mark.parametrize("actuator", SERVOS)
def test_an_actuator_is_a_servo_with_mujocos_force(actuator: str, tmp_path: Path) -> None:
    kind, kp, kd, limit = SERVOS[actuator]
    path = written(tmp_path, actuated(actuator))
    model = read_mjcf(path, floating=False)
    (servo,) = model.actuators
    assert (servo.joint, servo.kind, model.joints[0].effort) == ("j", kind, limit)
    values = servo.values
    gains: dict[str, Callable[[Any], tuple[float, float]]] = {
        "pid": lambda v: (v["kp"], v.get("kd", 0.0)),
        "velocity": lambda v: (0.0, v["gain"]),
        "effort": lambda _: (0.0, 0.0),
        "cascade": lambda v: (v["gain"] * v["kv"] * v["kp"], v["gain"] * v["kv"]),
        "dc": lambda v: (
            v["gain"] * v["supply"] * v["torque_constant"] / v["resistance"],
            v["torque_constant"] ** 2 / v["resistance"],
        ),
    }
    stiffness, damping = gains[kind](values)
    assert (stiffness, damping) == pytest.approx((kp, kd))
    m = mujoco.MjModel.from_xml_path(str(path))  # and this is what MuJoCo does, away from its limits
    d = mujoco.MjData(m)
    gear = m.actuator_gear[0, 0]
    d.qpos[0], d.qvel[0] = 0.01, 0.02
    if stiffness:
        d.ctrl[0] = gear * 0.03
    mujoco.mj_forward(m, d)
    assert d.qfrc_actuator[0] == pytest.approx(stiffness * 0.02 - damping * 0.02)


LOST = {
    '<velocity joint="j" kv="3"/>': "it takes velocities",
    '<intvelocity joint="j" kp="3" actrange="-1 1"/>': "dynamics integrator are no servo",
    '<general joint="j" dyntype="filter" dynprm="0.05" gainprm="4" biastype="affine" biasprm="1 -4 0"/>': (
        "filter of 0.05 s is left out"
    ),
    '<position joint="j" kp="3"/><position joint="j" kp="4"/>': "driven by another one already",
    '<position joint="j" kp="3" forcerange="-1 2"/>': "effort limits -1 and 2 differ",
    '<motor joint="j"/>': "it takes efforts",
    f'<dcmotor joint="j" {MOTOR} cogging=".1 20 .3" controller="4"/>': (
        "effect torque_ripple: amplitude 0.1, periods 20, phase 0.3"
    ),
    f'<dcmotor joint="j" {MOTOR} controller="4 0 0 0 0 12" />': (
        "effect torque_speed_limit: stall_torque 7.2, no_load_speed 8"
    ),
}


@pytest.mark.parametrize("actuator", LOST)
def test_what_a_servo_cannot_say_is_said(actuator: str, tmp_path: Path) -> None:
    notes = read_mjcf(written(tmp_path, actuated(actuator)), floating=False).notes
    assert any(LOST[actuator] in note for note in notes), notes


def world(content: str, rest: str = "") -> str:
    return f"<mujoco><worldbody>{content}</worldbody>{rest}</mujoco>"


def test_what_else_is_lost_is_said(tmp_path: Path) -> None:
    text = world(
        f'<body name="cube" pos="1 0 1"><freejoint/><geom size=".1"/></body>'
        f'<body name="arm" gravcomp="1"><joint name="j" stiffness="3" springref="20"/>{INERTIAL}</body>',
        '<option gravity="0 0 -1.6" density="1.2"/>',
    )
    notes = " ".join(read_mjcf(written(tmp_path, text), floating=False).notes)
    for part in ("body cube", "spring of 3", "gravcomp", "gravity is 0 0 -1.6", "fluid"):
        assert part in notes


def test_pictures_and_meshes_that_are_missing_are_no_error(tmp_path: Path) -> None:
    text = world(
        f'<body name="arm"><joint name="j"/>{INERTIAL}'
        '<geom type="mesh" mesh="m" material="t" contype="0" conaffinity="0"/></body>',
        '<asset><mesh name="m" file="none.stl"/><texture name="t" type="2d" file="none.png"/>'
        '<material name="t" texture="t"/></asset>',
    )
    assert read_mjcf(written(tmp_path, text), floating=False).joint_names == ["j"]


def test_shapes_touch_a_plane_where_mujoco_has_them(tmp_path: Path) -> None:
    """The lowest point of box, cylinder, capsule, sphere and mesh, however they are turned."""
    shapes = {
        "sphere": '<geom type="sphere" size=".1" pos=".1 .2 .3" euler="0 0 10"/>',
        "capsule": '<geom type="capsule" size=".05 .2" pos=".1 .2 .3" euler="30 50 10"/>',
        "box": '<geom type="box" size=".1 .2 .3" pos=".1 .2 .3" euler="30 50 10"/>',
        "mesh": '<geom type="mesh" mesh="m" pos=".1 .2 .3" euler="30 50 10"/>',
    }
    corners = np.array([[0, 0, 0], [0.3, 0, 0], [0, 0.2, 0], [0, 0, 0.5]])
    asset = f'<asset><mesh name="m" vertex="{" ".join(map(str, corners.ravel()))}"/></asset>'
    for name, geom in shapes.items():
        path = written(tmp_path, world(f'<body name="b"><freejoint/>{INERTIAL}{geom}</body>', asset))
        (link,) = read_mjcf(path, floating=True).links
        ours = min(s.center[2] - s.radius for s in link.spheres)
        m = mujoco.MjModel.from_xml_string(
            path.read_text().replace(
                "<worldbody>", '<worldbody><geom name="p" type="plane" size="9 9 .1" pos="0 0 -3"/>'
            )
        )
        d = mujoco.MjData(m)
        mujoco.mj_forward(m, d)
        distance = mujoco.mj_geomDistance(m, d, 0, 1, 100.0, None)
        assert ours == pytest.approx(distance - 3.0, abs=1e-3), name


BAD = {
    "not well-formed": ("<mujoco><worldbody>", "is not a MJCF file that MuJoCo takes"),
    "unknown attribute": (world('<body mess="1"/>'), "unrecognized attribute"),
    "a ball joint": (world(f'<body name="b"><joint type="ball"/>{INERTIAL}</body>'), "body b has a ball joint"),
    "two joints": (
        world(f'<body name="b"><joint name="x"/><joint name="y" axis="0 1 0"/>{INERTIAL}</body>'),
        "body b has 2 joints; expected one",
    ),
    "nothing moves": (world(f'<body name="b">{INERTIAL}</body>'), "nothing can move"),
    "a loop": (
        world(
            BAR + BAR.replace('"arm"', '"leg"').replace('"j"', '"k"'),
            '<equality><connect body1="arm" body2="leg" anchor="0 0 0"/></equality>',
        ),
        "the equality connect between arm and leg closes a loop; expected a tree",
    ),
    "a mesh that weighs": (
        world(
            '<body name="b"><joint/><geom type="mesh" mesh="m"/></body>',
            '<asset><mesh name="m" file="none.stl"/></asset>',
        ),
        "none.stl",
    ),
}


@pytest.mark.parametrize("case", BAD)
def test_what_cannot_be_simulated_is_one_sentence(case: str, tmp_path: Path) -> None:
    text, sentence = BAD[case]
    path = written(tmp_path, text)
    with pytest.raises(ModelError) as error:
        read_model(path, floating=False)
    assert str(error.value).startswith(f"{path}: ")
    assert sentence in str(error.value)
    assert "\n" not in str(error.value)


def test_two_robots_that_float_are_one_too_many(tmp_path: Path) -> None:
    robots = "".join(f'<body name="{n}"><freejoint/>{INERTIAL}</body>' for n in ("one", "two"))
    with pytest.raises(ModelError, match="expected one robot whose base moves, found one, two"):
        read_mjcf(written(tmp_path, world(robots)), floating=True)
