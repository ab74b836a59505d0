"""Cables, stops, and damping between rotor and link, against what a pencil says."""

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
    solves_exactly,
    wheel,
)
from realitygap.files.errors import InputError
from realitygap.simulate.start import holding_effort

WHOLE = LINK + ARMATURE


@everywhere
def test_a_cable_swings_the_joint_about_its_rest(engine: str) -> None:
    plant = added(effort_servo(wheel()), "cable_spring", stiffness=2.0, rest=0.3)
    out = run(plant, 0.0, 5.0, engine=engine)
    swing = out.position[:, 0] - 0.3
    crossings = out.time[1:][(swing[:-1] < 0) & (swing[1:] >= 0)]
    assert_allclose(2 * np.pi / np.diff(crossings).mean(), np.sqrt(2.0 / WHOLE), rtol=1e-3)
    assert_allclose(swing[-1000:].max(), 0.3, rtol=1e-4, err_msg="a spring does not lose energy")


def test_a_cable_holds_a_pendulum_where_its_torque_is_gravity_s() -> None:
    plant = added(effort_servo(pendulum()), "cable_spring", stiffness=1.5, rest=0.8)
    plant.drive["viscous"] = 0.3
    q = run(plant, 0.0, 4.0).position[-1]
    assert_allclose(1.5 * (0.8 - q), MASS * 9.81 * LENGTH * np.sin(q), atol=1e-6)
    assert_allclose(holding_effort(plant, q), 0.0, atol=1e-6)


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("cable_spring", {"stiffness": 1e5}),
        *(("joint_stop", {"lower": -0.05, "upper": 0.05, "stiffness": k}) for k in (1e2, 1e4, 1e5, 1e6, 1e8)),
    ],
)
@pytest.mark.parametrize("speed", [1.0, 1.313])
def test_springs_are_stable_at_any_stiffness(name: str, values: dict[str, Any], speed: float) -> None:
    """No stop throws a joint back faster than it came, also where the step does not resolve it."""
    out = run(added(effort_servo(wheel()), name, **values), 0.0, 1.0, velocity=speed)
    assert np.abs(out.velocity).max() < 1.03 * speed
    assert np.abs(out.position).max() < 0.05 + 1.05 * speed * np.sqrt(WHOLE / values["stiffness"]) + speed * H


@everywhere
def test_a_stop_gives_back_what_it_takes(engine: str) -> None:
    """A wheel that runs against a spring leaves it after half a period with the opposite speed."""
    plant = added(effort_servo(wheel()), "joint_stop", upper=0.2, stiffness=50.0)
    out = run(plant, 0.0, 0.5, engine=engine, velocity=2.0)
    q, w = out.position[:, 0], out.velocity[:, 0]
    rate = np.sqrt(50.0 / WHOLE)
    assert_allclose(w[out.time < 0.099], 2.0, rtol=1e-9 if solves_exactly(engine) else 2e-5)
    assert_allclose(w[out.time > 0.1 + np.pi / rate + 2 * H], -2.0, atol=0.02)
    assert_allclose(q.max() - 0.2, 2.0 / rate, rtol=0.02)


@everywhere
def test_a_servo_that_presses_against_a_stop_stays_there(engine: str) -> None:
    plant = added(wheel(), "joint_stop", lower=-0.2, upper=0.2, stiffness=200.0)
    stiffness = 5.0 * 15.0 * 2.19 / 2.96
    for command in (0.3, -0.3):
        q = run(plant, command, 1.5, engine=engine).position[-1, 0]
        assert_allclose(stiffness * (command - q), 200.0 * (q - np.sign(command) * 0.2), rtol=1e-4)
    free = run(plant, 0.15, 1.5, engine=engine).position
    assert_allclose(free, run(wheel(), 0.15, 1.5, engine=engine).position, atol=1e-12)


def test_a_stop_with_crossed_ends_is_an_error() -> None:
    with pytest.raises(InputError, match="expected lower below upper"):
        added(wheel(), "joint_stop", lower=0.5, upper=0.2, stiffness=10.0)


@everywhere
def test_damping_of_a_compliance_ends_its_ringing(engine: str) -> None:
    """The relative motion of rotor and link decays with damping/2·(1/I₁ + 1/I₂)."""
    plant = added(effort_servo(wheel()), "joint_compliance", stiffness=100.0, damping=0.02)
    plant.drive["constant"] = 0.05
    out = run(plant, 0.0, 0.6, engine=engine)
    ringing = out.velocity[:, 0] - 0.05 / WHOLE * (out.time + H / 2)
    peaks = np.flatnonzero((ringing[1:-1] > ringing[:-2]) & (ringing[1:-1] > ringing[2:])) + 1
    rate = -np.polyfit(out.time[peaks], np.log(ringing[peaks]), 1)[0]
    assert_allclose(rate, 0.5 * 0.02 * (1 / LINK + 1 / ARMATURE), rtol=0.05)


@pytest.mark.parametrize("damping", [0.05, 1.0, 100.0])
def test_grease_in_a_gap_drags_the_link_along(damping: float) -> None:
    """Within the dead zone the difference of speeds settles at what the motor's torque drags it to."""
    plant = added(effort_servo(wheel()), "backlash", angle=0.4, damping=damping)
    out = run(plant, 0.02, 0.12)
    # the rotor's torque shared: the link gets LINK/(LINK + ARMATURE) of it once the difference has settled
    rate = damping * (1 / LINK + 1 / ARMATURE)
    t = out.time + H / 2
    common = 0.02 / WHOLE
    slip = 0.02 / ARMATURE / rate * (1 - np.exp(-rate * t))
    exact = common * t - ARMATURE / WHOLE * slip
    assert_allclose(out.velocity[:, 0], exact, atol=2e-3 * exact[-1] + 1e-5)
