"""A servo that is switched off gives no torque but for its braking, and begins anew when it is switched on again."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from one_joint import RESISTANCE, TORQUE_CONSTANT, H, added, one_step, run, wheel
from realitygap.robot.drive import CASCADE, DC, LOG, PID, SPEED, STATE, VELOCITY
from realitygap.robot.drive_law import drive_effort
from realitygap.robot.plant import Plant

KINDS: dict[str, dict[str, float]] = {
    "dc": {"kind": DC},
    "pid": {"kind": PID, "kp": 30.0, "ki": 40.0, "kd": 0.8, "derivative_lag": 3e-3},
    "cascade": {"kind": CASCADE, "gain": 0.05, "kv": 20.0, "kp": 30.0, "derivative_lag": 3e-3},
    "velocity": {"kind": SPEED, "meaning": VELOCITY, "gain": 0.8},
    "sampled": {"kind": DC, "servo_rate": 100.0},
}


def of(drive: dict[str, float]) -> Plant:
    plant = wheel()
    for name, value in drive.items():
        plant.drive[name] = value
    return plant


@pytest.mark.parametrize("drive", KINDS.values(), ids=list(KINDS))
def test_what_it_did_before_is_forgotten(drive: dict[str, float]) -> None:
    """On, off for a while, and on again: from there on it moves as one that is switched on there for the first time."""
    plant, goal = of(drive), np.full(400, 0.7)
    goal[100:200] = np.nan
    again = run(plant, goal, 0.3)
    assert_allclose(again.effort[101:199], 0.0, atol=1e-15)
    assert np.abs(again.effort[:99]).max() > 0.1
    first = np.flatnonzero(again.time >= 0.2 - 1e-9)[0]
    before = np.full(400, np.nan)
    before[first:] = goal[first:]
    start = {"position": float(again.position[150, 0]), "velocity": float(again.velocity[150, 0])}
    fresh = run(plant, before[150:], 0.15, **start)  # type: ignore[arg-type]
    assert_allclose(fresh.position[: len(again.position) - 150], again.position[150:], atol=1e-9)


def test_the_current_that_it_had_is_gone() -> None:
    """The torque begins to rise from none, as exp(−t/time) tells, however much there was before."""
    plant = added(wheel(), "current_lag", time=0.05)
    plant.drive["armature"] = 1e9
    goal = np.full(400, 0.1)
    goal[100:150] = np.nan
    out = run(plant, goal, 0.39)
    full = 0.1 * 5.0 * 15.0 * TORQUE_CONSTANT / RESISTANCE
    assert_allclose(out.effort[:99, 0], full, rtol=1e-6)
    on = int(np.flatnonzero(out.effort[:, 0] == 0.0)[-1]) + 1
    since = H * (np.arange(len(out.time) - on - 2) + 0.5)
    assert_allclose(out.effort[on + 1 : -1, 0], full * (1 - np.exp(-(since + H) / 0.05)), atol=0.03 * full)


def test_it_brakes_with_what_heat_leaves_of_its_constant() -> None:
    plant = added(added(wheel(), "motor_braking", share=0.5), "motor_heating", loss=0.1)
    motor, _ = one_step(plant, np.full(1, np.nan), np.array([2.0]), t=4.0)
    assert_allclose(motor, -0.5 * (0.6 * TORQUE_CONSTANT) ** 2 / RESISTANCE * 2.0)


@pytest.mark.parametrize("off_next", [False, True])
def test_in_its_last_step_it_is_as_before(off_next: bool) -> None:
    """A command that ends has no rate: there is none after it."""
    plant = of({"kind": PID, "kp": 30.0, "kd": 0.8})
    state, log = np.zeros(1, STATE), np.zeros(1, LOG)
    command, zero = np.array([0.2]), np.zeros(1)
    upcoming = np.full(1, np.nan) if off_next else command
    law = [np.zeros(1) for _ in range(3)]
    drive_effort(plant.drive, state, command, upcoming, zero, zero, zero, plant.inertia(), 0.0, 0.0, H, *law, log)
    assert log["motor"] == pytest.approx(30.0 * 0.2)


def test_across_play_a_servo_knows_the_speed_of_its_encoder_and_not_of_its_rotor() -> None:
    """The rotor runs through the gap while the link, which carries the encoder, rests: there is nothing to damp."""
    plant = added(of({"kind": PID, "kp": 0.0, "kd": 0.8}), "backlash", angle=0.4)
    state, log = np.zeros(1, STATE), np.zeros(1, LOG)
    armature = float(plant.drive["armature"][0])
    state["begun"], state["mass"], state["momentum"] = 2, armature, 3.0 * armature
    zero, law = np.zeros(1), [np.zeros(1) for _ in range(3)]
    drive_effort(plant.drive, state, zero, zero, zero, zero, zero, plant.inertia(), 0.0, 0.0, H, *law, log)
    assert log["rotor"] == pytest.approx(3.0)
    assert log["motor"] - log["emf"] * log["rotor"] == pytest.approx(0.0)
