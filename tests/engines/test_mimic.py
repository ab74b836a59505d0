"""Mimic joints: two coupled pendulums are one machine of one degree of freedom, in every engine."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import realitygap_engines as engines
from realitygap_engines import Ground, Physics, State, Unsupported
from realitygap_engines.engine import GRAVITY
from realitygap_engines.errors import ModelError
from realitygap_engines.model.hold import hold
from realitygap_engines.model.read import read_model
from realitygap_engines.model.robot import Joint, Link, Mimic, Model

H = 1e-3
MASS, ARM, OWN = (0.5, 0.8), (0.2, 0.15), (1e-3, 2e-3)
MULTIPLIER, OFFSET = -1.5, 0.3
EXACT = {"ode": 5e-4, "pybullet": 1e-6}
"""[rad] How near an engine is after a second; ODE's step is forward dynamics within 3e-5. Others: 1e-9."""


def pendulums(**more: Any) -> Model:
    """Two pendulums beside each other on a fixed base; the second follows the first."""
    base = Link("base", 1.0, np.zeros(3), np.eye(3) * 1e-3)
    axis = np.array([0.0, 1.0, 0.0])
    links = [Link(f"bob{i}", MASS[i], np.array([0.0, 0.0, -ARM[i]]), np.eye(3) * OWN[i]) for i in range(2)]
    lead = Joint("lead", False, 0, np.eye(4), axis, **more)
    follower = replace(lead, name="follower", mimic=Mimic("lead", MULTIPLIER, OFFSET))
    return Model("pendulums", (base, *links), (lead, follower), False)


def reduced(
    q: float, w: float, steps: int, *, armature: float, damping: float, friction: float, effort: float
) -> np.ndarray:
    """The lead's angle on every step of the joint law of the machine that both are together."""
    inertia = sum(
        (own + m * a * a + armature) * k * k for m, a, own, k in zip(MASS, ARM, OWN, (1, MULTIPLIER), strict=True)
    )
    brake, bound = damping * (1 + MULTIPLIER**2), friction * (1 + abs(MULTIPLIER))
    out = []
    for _ in range(steps):
        out.append(q)
        gravity = -GRAVITY * (
            MASS[0] * ARM[0] * np.sin(q) + MULTIPLIER * MASS[1] * ARM[1] * np.sin(MULTIPLIER * q + OFFSET)
        )
        free = inertia * w + H * (gravity + effort)
        slowed = max(free - H * bound, 0.0) + min(free + H * bound, 0.0)
        w = slowed / (inertia + H * brake)
        q += H * w
    return np.array(out)


@pytest.mark.parametrize("engine", engines.available())
@pytest.mark.parametrize(
    "law",
    [
        {"armature": 0.0, "damping": 0.0, "friction": 0.0, "effort": 0.0},
        {"armature": 0.02, "damping": 0.03, "friction": 0.0, "effort": 0.4},
        {"armature": 0.02, "damping": 0.0, "friction": 0.08, "effort": 0.0},
    ],
    ids=["free", "driven", "dry friction"],
)
def test_two_coupled_pendulums_swing_as_one_machine(engine: str, law: dict[str, float]) -> None:
    steps = 1000
    expected = reduced(0.9, 0.0, steps, **law)
    lead, follower = np.empty(steps), np.empty(steps)
    position, velocity = np.zeros(2), np.zeros(2)
    with engines.load(engine).open(pendulums(armature=law["armature"]), Physics(H)) as simulation:
        simulation.reset(State(np.array([0.9, 0.0]), np.zeros(2)))  # where the follower is said to be does not matter
        for k in range(steps):
            simulation.read(position, velocity, np.zeros(13))
            lead[k], follower[k] = position
            simulation.step(np.array([law["effort"], 0.0]), np.full(2, law["damping"]), np.full(2, law["friction"]))
    exact = EXACT.get(engine, 1e-9)
    np.testing.assert_allclose(lead, expected, rtol=0, atol=exact)
    np.testing.assert_allclose(follower, MULTIPLIER * lead + OFFSET, rtol=0, atol=exact)


@pytest.mark.parametrize("engine", engines.available())
def test_a_coupled_machine_that_sticks_stays(engine: str) -> None:
    """Dry friction of both joints holds both, however little each could hold alone."""
    position, velocity = np.zeros(2), np.zeros(2)
    with engines.load(engine).open(pendulums(), Physics(H)) as simulation:
        simulation.reset(State(np.array([0.3, 0.0]), np.zeros(2)))
        for _ in range(500):
            simulation.step(np.zeros(2), np.zeros(2), np.array([0.2, 0.5]))
        simulation.read(position, velocity, np.zeros(13))
        dry = simulation.dry_friction()
    np.testing.assert_allclose(position, [0.3, MULTIPLIER * 0.3 + OFFSET], rtol=0, atol=1e-6)
    weight = GRAVITY * np.array(MASS) * np.array(ARM) * np.sin(position)
    assert dry @ [1.0, MULTIPLIER] == pytest.approx(weight @ [1.0, MULTIPLIER], rel=1e-3)


@pytest.mark.parametrize("engine", engines.available())
def test_what_a_coupled_motion_takes_is_taken_by_the_lead(engine: str) -> None:
    with engines.load(engine).open(pendulums(), Physics(H)) as simulation:
        start = State(np.zeros(2), np.zeros(2))
        q, a = 0.4, 2.0
        effort = simulation.inverse_dynamics(start, np.array([[q, 9.0]]), np.zeros((1, 2)), np.array([[a, 9.0]]))[0]
    inertia = sum((own + m * x * x) * k * k for m, x, own, k in zip(MASS, ARM, OWN, (1, MULTIPLIER), strict=True))
    weight = GRAVITY * (MASS[0] * ARM[0] * np.sin(q) + MULTIPLIER * MASS[1] * ARM[1] * np.sin(MULTIPLIER * q + OFFSET))
    assert effort == pytest.approx([inertia * a + weight, 0.0], rel=1e-6, abs=1e-9)


@pytest.mark.parametrize("engine", engines.available())
def test_on_the_ground_there_are_none(engine: str) -> None:
    assert engines.load(engine).capabilities()["mimic_joints"].level == "emulated"
    with pytest.raises(Unsupported, match="mimic joints on the ground"):
        engines.load(engine).open(pendulums(), Physics(H, ground=Ground()))


INERTIAL = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'


def test_a_urdf_says_mimics_of_mimics(tmp_path: Path) -> None:
    links = "".join(f'<link name="{n}">{INERTIAL}</link>' for n in "abcd")
    joints = [("ab", "a", "b", ""), ("ac", "a", "c", '<mimic joint="ab" multiplier="-2" offset="0.5"/>')]
    joints.append(("cd", "c", "d", '<mimic joint="ac" multiplier="3"/>'))
    text = "".join(
        f'<joint name="{n}" type="continuous"><parent link="{p}"/><child link="{c}"/><axis xyz="0 0 1"/>{m}</joint>'
        for n, p, c, m in joints
    )
    path = tmp_path / "r.urdf"
    path.write_text(f'<robot name="r">{links}{text}</robot>')
    model = read_model(path, floating=False)
    assert [j.mimic for j in model.joints] == [None, Mimic("ab", -2.0, 0.5), Mimic("ab", -6.0, 1.5)]
    assert hold(model, {0: 0.1}).joints == ()  # what mimics a held joint is held with it


def test_an_mjcf_says_them_as_equalities(tmp_path: Path) -> None:
    body = '<body name="{0}"><joint name="{0}" ref="{1}"/><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/></body>'
    path = tmp_path / "r.xml"

    def written(polynomial: str) -> Path:
        path.write_text(
            f'<mujoco><compiler angle="radian"/><worldbody>{body.format("x", 0.2)}{body.format("y", 0.1)}</worldbody>'
            f'<equality><joint joint1="y" joint2="x" polycoef="{polynomial}"/></equality></mujoco>'
        )
        return path

    mimic = read_model(written("0.3 -2 0 0 0"), floating=False).joints[1].mimic
    assert mimic is not None
    assert (mimic.joint, mimic.multiplier) == ("x", -2.0)
    assert mimic.offset == pytest.approx(0.1 + 0.3 + 2 * 0.2)
    with pytest.raises(ModelError, match="equality of joint y is no linear coupling"):
        read_model(written("0 1 0.5 0 0"), floating=False)
