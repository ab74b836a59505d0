"""Friction against what a pencil says, in every engine: stuck, sliding, at breakaway and under load."""

from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from one_joint import (
    ARMATURE,
    LENGTH,
    LINK,
    MASS,
    H,
    added,
    effort_servo,
    everywhere,
    pendulum,
    run,
    slider,
    solves_exactly,
    wheel,
)
from realitygap.robot.drive import LOG, STATE
from realitygap.robot.drive_law import drive_effort


@everywhere
@pytest.mark.parametrize("name", ["coulomb_friction", "stribeck_friction"])
def test_a_joint_held_by_static_friction_stays(name: str, engine: str) -> None:
    """Creep at most 1e-3 rad/s at 85 % of breakaway; at 115 % it moves."""
    values: dict[str, Any] = (
        {"torque": 0.2} if name == "coulomb_friction" else {"static": 0.2, "coulomb": 0.1, "velocity": 0.5}
    )
    plant = added(effort_servo(wheel()), name, **values)
    held = run(plant, 0.17, engine=engine)
    assert abs(held.position[-1, 0] - held.position[100, 0]) / (held.time[-1] - 0.1) < 1e-3
    assert np.abs(held.velocity).max() < 1e-3
    assert run(plant, 0.23, engine=engine).velocity[-1, 0] > 0.1


@everywhere
def test_a_sliding_joint_slows_as_ma_is_minus_f(engine: str) -> None:
    plant = added(effort_servo(wheel()), "coulomb_friction", torque=0.2)
    out = run(plant, 0.0, 0.6, engine=engine, velocity=2.0)
    slowing = 0.2 / (LINK + ARMATURE)
    until = 2.0 / slowing
    middle = out.time < until - 0.01
    # MuJoCo's friction is a soft constraint that gives 1e-3 of the torque away
    assert_allclose(out.velocity[middle, 0], 2.0 - slowing * (out.time[middle] + H / 2), atol=3e-3)
    assert np.abs(out.velocity[out.time > until + 0.02]).max() < 1e-3


@everywhere
def test_viscous_friction_decays_exponentially(engine: str) -> None:
    plant = added(effort_servo(wheel()), "viscous_friction", coefficient=0.4)
    out = run(plant, 0.0, engine=engine, velocity=2.0)
    rate = 0.4 / (LINK + ARMATURE)
    exact = 2.0 * np.exp(-rate * out.time) * 0.5 * (1 + np.exp(-rate * H))
    rounding = 1e-9 if solves_exactly(engine) else 1e-5
    assert_allclose(out.velocity[:, 0], exact, rtol=rounding, err_msg="the law makes a free decay exact")


@everywhere
def test_friction_that_grows_from_rest_slows_as_the_hyperbolic_sine_decays(engine: str) -> None:
    """m·dω/dt = −torque·tanh(ω/onset) has sinh(ω/onset) = sinh(ω₀/onset)·exp(−torque·t/(m·onset))."""
    plant = added(effort_servo(wheel()), "coulomb_friction", torque=0.2, onset=0.3)
    for h, error in ((H, 1.6e-3), (H / 4, 4e-4)):  # it is half a step late
        out = run(plant, 0.0, 0.6, engine=engine, velocity=0.8, h=h)
        decay = np.exp(-0.2 * (out.time + h / 2) / (0.3 * (LINK + ARMATURE)))
        assert_allclose(out.velocity[1:-1, 0], 0.3 * np.arcsinh(np.sinh(0.8 / 0.3) * decay)[1:-1], atol=error)


@everywhere
@pytest.mark.parametrize("onset", [1e-4, 0.02, 0.3])
@pytest.mark.parametrize("softened", [False, True])
def test_friction_that_grows_from_rest_creeps_at_the_speed_that_balances_it(
    softened: bool, onset: float, engine: str
) -> None:
    """0.1 N·m against 0.2: ω = onset·atanh(0.5), also where friction grows within far less than a step."""
    plant = added(effort_servo(wheel()), "coulomb_friction", torque=0.2, onset=onset)
    if softened:
        plant = added(plant, "joint_compliance", stiffness=50.0, damping=0.05)
    out = run(plant, 0.1, 1.5, engine=engine)
    assert_allclose(out.velocity[-1, 0], onset * np.arctanh(0.5), rtol=1e-3, atol=1e-5)


@everywhere
@pytest.mark.parametrize("over", [1e-3, 0.02])
def test_friction_that_builds_up_takes_the_work_that_it_does(over: float, engine: str) -> None:
    """To one side ½·m·(ω₀² − ω²) = torque·(q − over·(1 − exp(−q/over))), whichever the time (Dahl)."""
    plant = added(effort_servo(wheel()), "coulomb_friction", torque=0.2, presliding=over)
    out = run(plant, 0.0, 0.6, engine=engine, velocity=1.0)
    q, w = out.position[:, 0], out.velocity[:, 0]
    forward = np.arange(len(q)) < np.argmax(q) - 1
    middle = 0.5 * (q[1:] + q[:-1])[forward[1:]]  # velocities sit half a step before positions
    work = 0.2 * (middle - over * (1.0 - np.exp(-middle / over)))
    left = 0.5 * (LINK + ARMATURE) * (w[0] ** 2 - w[1:][forward[1:]] ** 2)
    assert_allclose(left, work, atol=0.01 * work[-1])


@everywhere
@pytest.mark.parametrize(("over", "grease"), [(1e-6, 5.0), (1e-3, 5.0), (0.02, 1.0)])
@pytest.mark.parametrize("softened", [False, True])
def test_friction_that_builds_up_holds_where_it_balances(
    softened: bool, over: float, grease: float, engine: str
) -> None:
    """Pulled slowly to 0.1 N·m of 0.2, so that nothing rings: q = −over·log(1 − 0.5), also where it builds up within
    far less than a step.
    """
    plant = added(effort_servo(wheel()), "coulomb_friction", torque=0.2, presliding=over)
    plant = added(plant, "viscous_friction", coefficient=grease)
    if softened:
        plant = added(plant, "joint_compliance", stiffness=50.0, damping=0.05)
    out = run(plant, np.minimum(np.arange(2500) * 1e-4, 0.1), 2.5, engine=engine)
    assert_allclose(out.position[-1, 0], -over * np.log(0.5), rtol=2e-3, atol=1e-9)
    assert abs(out.velocity[-1, 0]) < 1e-4


@pytest.mark.parametrize("mass", [0.1, 95.0])
def test_a_linear_axis_moves_at_its_terminal_speed(mass: float) -> None:
    plant = added(effort_servo(slider(mass)), "viscous_friction", coefficient=203.5)
    plant = added(plant, "coulomb_friction", torque=20.39)
    out = run(plant, 100.0, 6.0)
    assert_allclose(out.velocity[-1, 0], (100 - 20.39) / 203.5, rtol=1e-3)


def test_stribeck_friction_breaks_away_and_drops() -> None:
    """Pulled by a slow ramp of torque: it holds up to `static`, then slides at `coulomb`."""
    plant = added(effort_servo(wheel()), "stribeck_friction", static=0.3, coulomb=0.1, velocity=0.2)
    ramp = np.minimum(np.arange(3000) * 2e-4, 0.33)
    out = run(plant, ramp, 2.4, joint_effort=True)
    moving = int(np.argmax(out.velocity[:, 0] > 5e-3))
    assert_allclose(ramp[moving], 0.3, atol=0.01)
    assert_allclose(out.effort[-1, 0], 0.33 - 0.1, atol=2e-3)
    bound = 0.1 + 0.2 * np.exp(-((np.array([0.0, 0.1, 0.2, 1.0]) / 0.2) ** 2))
    for speed, expected in zip((0.0, 0.1, 0.2, 1.0), bound, strict=True):
        slow = run(plant, 0.0, 2 * H, velocity=speed, joint_effort=True)
        assert_allclose(abs(slow.effort[0, 0]), expected if speed else 0.0, atol=2e-3)


@everywhere
def test_load_dependent_friction_grows_with_the_transmitted_torque(engine: str) -> None:
    """Without friction of its own, a joint that transmits τ has coefficient·τ: stuck it holds, moving it slows."""
    plant = pendulum()
    effort_servo(plant)
    plant = added(plant, "load_dependent_friction", coefficient=0.3)
    angle = 0.6
    load = MASS * 9.81 * LENGTH * np.sin(angle)
    # at rest τ_m − τ_l = τ_m + load on either side; it holds while |τ_m − load| ≤ 0.3·½·(τ_m + load)
    low, high = load * (1 - 0.15) / (1 + 0.15), load * (1 + 0.15) / (1 - 0.15)
    for torque, moves in ((low - 0.02, True), (low + 0.03, False), (high - 0.03, False), (high + 0.02, True)):
        out = run(plant, torque, 0.4, engine=engine, position=angle)
        assert (abs(out.position[-1, 0] - angle) > 5e-3) == moves, torque
    # moving: m·a = τ_m − load − friction
    torque = 2 * high
    out = run(plant, torque, 0.02, engine=engine, position=angle)
    gear = 0.15 * (torque + load)
    acceleration = (out.velocity[-1, 0] - out.velocity[5, 0]) / (out.time[-1] - out.time[5])
    # the load holds the link's inertia too: solve a = (τ_m − load − 0.15·(τ_m + load + LINK·a))/(LINK + ARMATURE)
    expected = (torque - load - gear) / (LINK + ARMATURE + 0.15 * LINK)
    assert_allclose(acceleration, expected, rtol=0.02)


def test_the_published_m4_counts_the_transmitted_torque_twice() -> None:
    """A coefficient c for |τ_m − τ_l| is 2·c here: at rest under a load L and a motor at L, the bound is 2·c·L."""
    plant = added(pendulum(), "load_dependent_friction", coefficient=0.0, static_coefficient=2 * 0.22, velocity=1.6)
    state, log = np.zeros(1, STATE), np.zeros(1, LOG)
    out = [np.zeros(1) for _ in range(3)]
    effort_servo(plant)
    load = np.array([0.8])
    zero = np.zeros(1)
    for _ in range(2):  # the joint rests: what the motor gives is what it transmits
        drive_effort(plant.drive, state, load, load, zero, zero, zero, plant.inertia(), 0.0, 0.0, H, *out, log)
    assert_allclose(out[2], 0.22 * abs(0.8 + 0.8))
