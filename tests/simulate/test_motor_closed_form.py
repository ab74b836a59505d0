"""Motor, supply, commands and sensors against what a pencil says."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from one_joint import (
    ARMATURE,
    LENGTH,
    LINK,
    MASS,
    RESISTANCE,
    SUPPLY,
    TORQUE_CONSTANT,
    H,
    added,
    effort_servo,
    everywhere,
    one_step,
    pendulum,
    run,
    wheel,
)
from realitygap.robot.drive import CASCADE, DC, DUTY, PID
from realitygap_engines.model.robot import Array


@pytest.mark.parametrize("supply", [12.0, 15.0])
def test_the_torque_speed_line_scales_with_the_voltage(supply: float) -> None:
    """Through stall torque kt·U/R at rest and no-load speed U/kt without torque."""
    plant = added(wheel(), "supply_voltage", supply=supply)
    plant.drive["meaning"] = DUTY
    stall, free = TORQUE_CONSTANT * supply / RESISTANCE, supply / TORQUE_CONSTANT
    for part in (0.0, 0.3, 1.0):
        motor, _ = one_step(plant, np.ones(1), np.array([part * free]))
        assert_allclose(motor, stall * (1 - part), atol=1e-12)


@pytest.mark.parametrize("kind", [DC, PID, CASCADE])
def test_the_torque_speed_limit_is_a_line_that_braking_lies_beyond(kind: int) -> None:
    plant = added(wheel(), "torque_speed_limit", stall_torque=4.0, no_load_speed=5.0)
    plant.drive["kind"], plant.drive["kp"], plant.drive["kv"] = kind, 1e3, 1.0
    for speed, sign, expected in ((0.0, 1, 4.0), (2.5, 1, 2.0), (2.5, -1, -6.0), (5.0, 1, 0.0), (6.0, 1, 0.0)):
        motor, _ = one_step(plant, np.array([sign * 10.0]), np.array([speed]))
        assert_allclose(motor, expected, atol=1e-12)
    reached = run(plant, 50.0, 1.5)
    assert 4.9 < reached.velocity.max() <= 5.0 + 1e-9


def test_servos_on_one_supply_sag_together() -> None:
    """Two stalled servos at full duty are two windings on a lead: bus = U/(1 + 2·R_s/R)."""
    plant = added(wheel(3), "voltage_sag", target=["joint0", "joint1"], resistance=0.5)  # type: ignore[arg-type]
    plant.drive["meaning"] = DUTY
    together, alone = SUPPLY / (1 + 2 * 0.5 / RESISTANCE), SUPPLY / (1 + 0.5 / RESISTANCE)
    motor, bus = one_step(plant, np.ones(3), np.zeros(3))
    assert_allclose(bus, [together, together, SUPPLY])
    assert_allclose(motor, TORQUE_CONSTANT / RESISTANCE * bus)
    _, bus = one_step(plant, np.array([1.0, np.nan, 1.0]), np.zeros(3))
    assert_allclose(bus[0], alone)


def test_servos_on_two_supplies_that_are_alike_do_not() -> None:
    plant = added(added(wheel(2), "voltage_sag", "joint0", resistance=0.5), "voltage_sag", "joint1", resistance=0.5)
    plant.drive["meaning"] = DUTY
    _, bus = one_step(plant, np.ones(2), np.zeros(2))
    assert_allclose(bus, SUPPLY / (1 + 0.5 / RESISTANCE))


@pytest.mark.parametrize("loss", [0.0, 0.1])
@pytest.mark.parametrize("duties", [[1.0, 0.5], [0.3, -0.8], [-0.2, 0.1]])
def test_the_power_on_a_bus_is_balanced(duties: list[float], loss: float) -> None:
    """bus = supply - R_s·Σ volts·current/bus: what the servos take is what comes through the lead, either way."""
    plant = added(added(wheel(2), "voltage_sag", resistance=0.5), "motor_heating", loss=loss)
    plant.drive["meaning"] = DUTY
    speed = np.array([2.0, 6.0])
    motor, bus = one_step(plant, np.array(duties), speed, t=3.0)
    power = np.array(duties) * bus * motor / (TORQUE_CONSTANT * (1.0 - 3.0 * loss))
    assert_allclose(bus, SUPPLY - 0.5 * power.sum() / bus)
    assert (power.sum() < 0) == (bus[0] > SUPPLY), "a servo that brakes feeds back and lifts the bus"


def test_heating_lowers_torque_and_induced_voltage_over_time() -> None:
    plant = added(wheel(), "motor_heating", loss=0.02)
    plant.drive["meaning"] = DUTY
    for t in (0.0, 10.0, 30.0, 80.0):
        kt = TORQUE_CONSTANT * max(1 - 0.02 * t, 0.0)
        motor, _ = one_step(plant, np.ones(1), np.array([2.0]), t)
        assert_allclose(motor, kt / RESISTANCE * (SUPPLY - kt * 2.0), atol=1e-12)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_saturation_takes_more_of_a_large_torque(sign: float) -> None:
    """What is left is 1/(1 + saturation·torque): a half where that product is one, and all of a small torque."""
    plant = added(effort_servo(wheel()), "motor_saturation", saturation=0.5)
    for asked in (1e-6, 1.0, 2.0):
        motor, _ = one_step(plant, np.array([sign * asked]), np.zeros(1))
        assert_allclose(motor, sign * asked / (1.0 + 0.5 * asked), rtol=1e-12)


@everywhere
def test_a_ripple_holds_the_joint_in_its_valleys(engine: str) -> None:
    """Its torque is −amplitude·sin(periods·q + phase): small swings about a valley have √(amplitude·periods/I)."""
    plant = added(effort_servo(wheel()), "torque_ripple", amplitude=0.1, periods=8.0, phase=0.4)
    out = run(plant, 0.0, 5.0, engine=engine, position=-0.05 + 0.005)
    swing = out.position[:, 0] + 0.05
    crossings = out.time[1:][(swing[:-1] < 0) & (swing[1:] >= 0)]
    assert_allclose(2 * np.pi / np.diff(crossings).mean(), np.sqrt(0.1 * 8.0 / (LINK + ARMATURE)), rtol=2e-3)


def test_a_constant_effort_moves_the_rest_pose() -> None:
    plant = added(pendulum(), "constant_effort", effort=0.3)
    plant.drive["viscous"] = 0.1
    out = run(plant, 0.0, 2.0)
    stiffness = 5.0 * SUPPLY * TORQUE_CONSTANT / RESISTANCE
    q = out.position[-1, 0]
    assert_allclose(stiffness * q + MASS * 9.81 * LENGTH * np.sin(q), 0.3, atol=1e-6)


@pytest.mark.parametrize("kind", [DC, PID, CASCADE])
def test_a_servo_that_gets_no_command_gives_no_torque(kind: int) -> None:
    plant = wheel()
    plant.drive["kind"], plant.drive["kp"], plant.drive["ki"], plant.drive["kd"] = kind, 50.0, 5.0, 1.0
    out = run(plant, np.nan, 0.2, velocity=1.0)
    assert_allclose(out.velocity, 1.0, rtol=1e-12)
    assert not out.effort.any()


@everywhere
def test_a_delay_of_part_of_a_step_is_exact(engine: str) -> None:
    """A command that is late by 3.37 steps gives what the plant without delay gives for that late command."""
    late = 3.37e-3
    t = 1e-3 * np.arange(1000, dtype=np.float64)

    def swing(time: Array) -> Array:
        return np.where(time > 0.1, 0.4 * np.sin(9.0 * (time - 0.1)) ** 2, 0.0)

    delayed = run(added(wheel(), "command_delay", time=late), swing(t), engine=engine)
    direct = run(wheel(), swing(t - late), engine=engine)
    assert_allclose(delayed.position, direct.position, atol=2e-6)
    assert np.abs(delayed.position - run(wheel(), swing(t), engine=engine).position).max() > 5e-3


@everywhere
def test_the_servo_regulates_the_reading(engine: str) -> None:
    """q = reading + angle: at rest the reading balances the load of the true pose."""
    plant = added(pendulum(), "joint_offset", angle=0.2)
    plant.drive["viscous"] = 0.1
    out = run(plant, 0.3, 2.0, engine=engine, position=0.2)
    assert_allclose(out.position[0, 0], 0.0, atol=1e-12)
    reading = out.position[-1, 0]
    stiffness = 5.0 * SUPPLY * TORQUE_CONSTANT / RESISTANCE
    assert_allclose(stiffness * (0.3 - reading), MASS * 9.81 * LENGTH * np.sin(reading + 0.2), atol=1e-6)


def test_the_hysteresis_of_the_effort_is_less_in_the_direction_of_motion_and_nothing_else() -> None:
    plain = effort_servo(wheel())
    for sign in (1.0, -1.0):
        told = added(plain, "effort_hysteresis", effort=sign * 0.3, onset=0.2)
        a, b = run(plain, 0.2), run(told, 0.2)
        assert_allclose(a.position, b.position, atol=0.0)
        assert_allclose(a.velocity, b.velocity, atol=0.0)
        assert_allclose(a.effort - b.effort, sign * 0.3 * np.tanh(a.velocity / 0.2), atol=1e-12)


def test_the_velocity_filter_is_a_low_pass_of_the_sensor_alone() -> None:
    plain = effort_servo(wheel())
    filtered = added(plain, "velocity_filter", time=0.05, scale=0.9)
    a, b = run(plain, 0.2), run(filtered, 0.2)
    assert_allclose(a.position, b.position, atol=0.0)
    slope = 0.2 / (LINK + ARMATURE)  # a ramp: the filter lags by its time constant
    assert_allclose(b.velocity[-1, 0], 0.9 * slope * (b.time[-1] + H / 2 - 0.05), rtol=2e-3)
