"""The start: joint angles as measured, the foot that is stood on level, the lowest point on the ground."""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from realitygap.audit.oracle import Oracle
from realitygap.files.errors import InputError
from realitygap.robot.drive import PID, neutral_drive
from realitygap.robot.plant import Plant
from realitygap.simulate.commands import Commands
from realitygap.simulate.start import start_integral, start_state
from realitygap.trace.trace import Trace
from realitygap_engines import Ground
from realitygap_engines.model.robot import (
    Array,
    axis_rotation,
    link_poses,
    lowest_point,
    quaternion_from_rotation,
    rotation_from_quaternion,
)
from realitygap_engines.model.urdf import read_urdf

INERTIAL = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
ANGLES = np.array([0.3, -0.5, 0.2, 0.4])


def leg(side: str, y: float) -> str:
    """A thigh that rolls and a foot that pitches, with a sole of 0.2 m × 0.1 m, mounted askew in the foot's axes."""
    thigh, foot = f"{side}_thigh", f"{side}_foot"
    box = '<geometry><box size="0.2 0.1 0.02"/></geometry>'
    sole = f'<collision><origin xyz="0.02 0 -0.05" rpy="0 0.3 0"/>{box}</collision>'
    ends = '<parent link="{}"/><child link="{}"/><limit lower="-2" upper="2" effort="1" velocity="1"/>'
    return (
        f'<link name="{thigh}">{INERTIAL}</link><link name="{foot}">{INERTIAL}{sole}</link>'
        f'<joint name="{side}_hip" type="revolute"><origin xyz="0 {y} -0.1"/><axis xyz="1 0 0"/>'
        f"{ends.format('torso', thigh)}</joint>"
        f'<joint name="{side}_ankle" type="revolute"><origin xyz="0 0 -0.3" rpy="0 -0.3 0"/><axis xyz="0 1 0"/>'
        f"{ends.format(thigh, foot)}</joint>"
    )


@pytest.fixture
def biped(tmp_path: Path) -> Plant:
    return plant(tmp_path)


def plant(folder: Path, *, floating: bool = True) -> Plant:
    path = folder / "biped.urdf"
    path.write_text(
        f'<robot name="b"><link name="torso">{INERTIAL}</link>{leg("left", 0.1)}{leg("right", -0.1)}</robot>'
    )
    model = read_urdf(path, floating=floating)
    n = len(model.joints)
    return Plant(model, neutral_drive(n), Ground(), np.zeros(n), np.zeros(n), np.ones(n), np.zeros(2))


def poses(plant: Plant, angles: Array, **known: Array | str) -> Array:
    state = start_state(plant, angles, **known)  # type: ignore[arg-type]
    base = np.eye(4)
    base[:3, :3] = rotation_from_quaternion(state.base_quaternion)
    base[:3, 3] = state.base_position
    return link_poses(plant.model, angles, base)


@pytest.mark.parametrize("foot", ["left_foot", "right_foot"])
@pytest.mark.parametrize("angles", [np.zeros(4), ANGLES, -2 * ANGLES])
def test_the_sole_is_level_and_on_the_ground(foot: str, angles: Array, biped: Plant) -> None:
    found = poses(biped, angles, stand_on=foot)
    i = [link.name for link in biped.model.links].index(foot)
    heights = np.sort([(found[i] @ [*s.center, 1])[2] - s.radius for s in biped.model.links[i].spheres])
    assert_allclose(heights[:4], heights[0], atol=1e-9)
    assert heights[4] > heights[0] + 0.015, "the upper side of the box is not the sole"
    assert lowest_point(biped.model, found) == pytest.approx(0, abs=1e-12)


def test_standing_keeps_the_heading(biped: Plant) -> None:
    rotation = rotation_from_quaternion(start_state(biped, ANGLES, stand_on="left_foot").base_quaternion)
    assert np.arctan2(rotation[1, 0], rotation[0, 0]) == pytest.approx(0, abs=1e-12)
    assert not np.allclose(rotation, np.eye(3)), "the torso leans"


def test_without_a_foot_the_base_is_upright_and_the_lowest_point_on_the_ground(biped: Plant) -> None:
    state = start_state(biped, ANGLES)
    assert_allclose(state.base_quaternion, [1, 0, 0, 0])
    assert lowest_point(biped.model, poses(biped, ANGLES)) == pytest.approx(0, abs=1e-12)
    assert_allclose(state.position, ANGLES)
    assert_allclose(state.velocity, 0)


def test_without_ground_the_base_stays_where_it_is(biped: Plant) -> None:
    biped.ground = None
    assert_allclose(start_state(biped, ANGLES).base_position, 0)


def test_a_recorded_pose_is_taken_as_it_is(biped: Plant) -> None:
    q = quaternion_from_rotation(axis_rotation(np.array([0.6, 0.0, 0.8]), 0.7))
    recorded = {
        "base_position": np.array([1.0, 2.0, 3.0]),
        "base_quaternion": q,
        "base_linear": np.array([0.1, 0.2, 0.3]),
        "base_angular": np.array([4.0, 5.0, 6.0]),
    }
    state = start_state(biped, ANGLES, stand_on="left_foot", **recorded)
    for name, value in recorded.items():
        assert_allclose(getattr(state, name), value, atol=1e-12)


def test_a_fixed_base_tilts_about_its_x_and_then_its_y(tmp_path: Path) -> None:
    held = plant(tmp_path, floating=False)
    held.base_tilt = np.array([0.2, -0.1])
    rotation = rotation_from_quaternion(start_state(held, ANGLES).base_quaternion)
    x, y = np.eye(3)[0], np.eye(3)[1]
    assert_allclose(rotation, axis_rotation(x, 0.2) @ axis_rotation(y, -0.1), atol=1e-12)
    assert_allclose(start_state(held, ANGLES).base_position, 0)


def test_standing_on_a_link_that_is_not_there(biped: Plant) -> None:
    with pytest.raises(InputError, match="found 'foot'; expected one of the links left_foot, left_thigh, right_foot"):
        start_state(biped, ANGLES, stand_on="foot")


def held(plant: Plant, effort: Array, lag: float, told: Commands | None = None) -> Array:
    """The integral told from 0.2 s in which every joint is held with these efforts (t, n), `lag` below 0.4 rad."""
    n = len(plant.model.joints)
    plant.drive["kind"], plant.drive["kp"], plant.drive["ki"] = PID, 20.0, 5.0
    time = 3.0 + np.linspace(0.0, 0.2, len(effort))
    measured = Trace(time, tuple(plant.model.joint_names), position=np.full((len(time), n), 0.4 - lag), effort=effort)
    told = told or Commands(np.array([0.0, 5.0]), np.array([[0.4] * n, [1.0] * n]))
    return start_integral(plant, measured, told, 3.0)


def test_the_integral_is_what_was_measured_beyond_the_proportional_part(biped: Plant) -> None:
    assert_allclose(held(biped, np.full((40, 4), 1.5), 0.01), np.full(4, 1.5 - 20.0 * 0.01))


def test_a_servo_that_is_never_commanded_does_not_shorten_the_look(biped: Plant) -> None:
    told = Commands(np.array([0.0, 0.01]), np.array([[0.4, 0.4, 0.4, np.nan]] * 2))
    noise = np.random.default_rng(0).standard_normal((40, 4))
    assert_allclose(held(biped, noise, 0.0, told), np.zeros(4))


def test_noise_charges_no_integral(biped: Plant) -> None:
    noise = np.random.default_rng(0).standard_normal((40, 4))
    assert_allclose(held(biped, noise, 0.0), np.zeros(4))


def test_without_measured_effort_the_integral_of_a_floating_robot_is_empty(biped: Plant) -> None:
    assert_allclose(held(biped, np.full((40, 4), np.nan), 0.0), np.zeros(4))


def test_without_measured_effort_the_integral_holds_a_fixed_robot(tmp_path: Path) -> None:
    fixed = plant(tmp_path, floating=False)
    fixed.base_tilt[:] = 0.1, -0.2
    fixed.drive["constant"] = 0.3
    told = held(fixed, np.full((40, 4), np.nan), 0.001)
    gravity = Oracle(fixed.model).inertia_and_bias(start_state(fixed, np.full(4, 0.399)))[1]
    assert_allclose(told, gravity - 0.3 - 20.0 * 0.001, atol=1e-6)


def test_a_servo_that_its_first_command_sets_in_motion_has_gathered_nothing(tmp_path: Path) -> None:
    assert_allclose(held(plant(tmp_path, floating=False), np.full((40, 4), np.nan), 0.39), np.zeros(4))
