"""Friction by direction and by angle, against what a pencil says."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from one_joint import ARMATURE, LINK, H, added, effort_servo, everywhere, run, wheel


@everywhere
@pytest.mark.parametrize(("push", "held"), [(0.17, True), (0.23, False), (-0.09, True), (-0.12, False)])
def test_a_joint_is_held_up_to_each_direction_s_friction(push: float, held: bool, engine: str) -> None:
    out = run(added(effort_servo(wheel()), "direction_friction", forward=0.2, backward=0.105), push, engine=engine)
    assert (np.abs(out.velocity[-1, 0]) < 1e-3) == held


@everywhere
@pytest.mark.parametrize(("speed", "friction"), [(2.0, 0.2), (-2.0, 0.1)])
def test_it_slows_by_the_friction_of_its_direction(speed: float, friction: float, engine: str) -> None:
    plant = added(effort_servo(wheel()), "direction_friction", forward=0.2, backward=0.1)
    out = run(plant, 0.0, 0.3, engine=engine, velocity=speed, joint_effort=True)
    slowing = np.sign(speed) * friction / (LINK + ARMATURE)
    assert_allclose(out.velocity[:-1, 0], speed - slowing * out.time[:-1], atol=4e-3)
    assert_allclose(out.effort[5:, 0], -np.sign(speed) * friction, atol=2e-3)


@everywhere
@pytest.mark.parametrize(("speed", "coefficient"), [(2.0, 0.32), (-2.0, 0.48)])
def test_viscous_friction_differs_by_direction(speed: float, coefficient: float, engine: str) -> None:
    plant = added(effort_servo(wheel()), "viscous_friction", coefficient=0.4)
    plant = added(plant, "direction_friction", forward=0.0, backward=0.0, asymmetry=-0.2)
    out = run(plant, 0.0, 0.3, engine=engine, velocity=speed, joint_effort=True)
    rate = coefficient / (LINK + ARMATURE)
    expected = speed * np.exp(-rate * out.time) * 0.5 * (1 + np.exp(-rate * H))
    assert_allclose(out.velocity[:-1, 0], expected[:-1], rtol=1e-5)
    assert_allclose(out.effort[1:-1, 0], -coefficient * out.velocity[1:-1, 0], rtol=1e-5)


def test_it_is_coulomb_friction_beside_half_of_the_difference() -> None:
    swing = 0.6 * np.sin(7.0 * 1e-3 * np.arange(900))
    other = added(added(wheel(), "coulomb_friction", torque=0.15), "constant_effort", effort=-0.05)
    out = run(added(wheel(), "direction_friction", forward=0.2, backward=0.1), swing, 0.8)
    assert_allclose(out.position, run(other, swing, 0.8).position, atol=1e-12)


@everywhere
def test_a_sliding_joint_does_the_work_of_its_uneven_friction(engine: str) -> None:
    """Energy lost on the way from 0 to q: torque·(q + share/periods·(1 − cos(periods·q)))."""
    plant = added(effort_servo(wheel()), "coulomb_friction", torque=0.2)
    plant = added(plant, "friction_ripple", share=0.6, periods=7.0, phase=0.0)
    out = run(plant, 0.0, 0.3, engine=engine, velocity=3.0)
    q = out.position[:, 0]
    work = 0.2 * (q + 0.6 / 7.0 * (1 - np.cos(7.0 * q)))
    speed = np.sqrt(9.0 - 2.0 * work / (LINK + ARMATURE))
    assert_allclose(out.velocity[:, 0], speed, atol=8e-3)
    assert q[-1] > 0.5


@everywhere
def test_a_joint_is_held_where_friction_is_large_and_not_where_it_is_small(engine: str) -> None:
    plant = added(effort_servo(wheel()), "coulomb_friction", torque=0.2)
    plant = added(plant, "friction_ripple", share=0.5, periods=1.0)
    for at, moves in ((np.pi / 2, False), (-np.pi / 2, True)):
        out = run(plant, 0.2, 0.3, engine=engine, position=at)
        assert (abs(out.position[-1, 0] - at) > 1e-2) == moves


def test_both_directions_change_with_the_angle() -> None:
    plant = added(effort_servo(wheel()), "direction_friction", forward=0.2, backward=0.1)
    plant = added(plant, "friction_ripple", share=0.5, periods=1.0)
    for speed, friction in ((1.0, -0.3), (-1.0, 0.15)):
        out = run(plant, 0.0, 4 * H, velocity=speed, position=np.pi / 2, joint_effort=True)
        assert_allclose(out.effort[1, 0], friction, atol=3e-3)
