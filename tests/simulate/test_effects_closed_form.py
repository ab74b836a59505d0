"""Effects against what a pencil says: closed forms of the one-joint bench, of the drive law and of the commands."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import realitygap_engines as engines
from numpy.testing import assert_allclose
from one_joint import (
    ARMATURE,
    AT_REST,
    INERTIA,
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
    slider,
    solves_exactly,
    wheel,
)
from realitygap.robot.drive import CASCADE, DC, DUTY, LOG, PID, STATE, neutral_drive
from realitygap.robot.drive_law import arrive, drive_effort
from realitygap.robot.effects import EFFECTS
from realitygap.robot.plant import Plant
from realitygap.simulate.commands import Commands
from realitygap.simulate.rollout import rollout
from realitygap.simulate.start import holding_effort, start_state
from realitygap.trace.trace import Trace
from realitygap_engines import Ground, Physics, State
from realitygap_engines.model.robot import Array, Link, Model, Sphere, rotation_from_rpy

# friction


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


# transmission


@everywhere
def test_compliance_rings_at_its_resonance(engine: str) -> None:
    """√(k·(1/I₁ + 1/I₂)) of a free rotor and link, and their common speed stays."""
    plant = added(effort_servo(wheel()), "joint_compliance", stiffness=100.0)
    out = run(plant, 0.0, 1.0, engine=engine, velocity=0.0)
    assert np.abs(out.position).max() < AT_REST
    plant.drive["constant"] = 0.05  # pushes the link, which pulls the rotor
    out = run(plant, 0.0, 1.0, engine=engine)
    steady = 0.05 / (LINK + ARMATURE)
    ringing = out.velocity[:, 0] - steady * (out.time + H / 2)
    crossings = out.time[1:][(ringing[:-1] < 0) & (ringing[1:] >= 0)]
    found = 2 * np.pi / np.diff(crossings).mean()
    assert_allclose(found, np.sqrt(100.0 * (1 / LINK + 1 / ARMATURE)), rtol=5e-3)
    # the rotor is driven by 1 − cos: its speed swings about the common one by steady·sin(Ωt)/Ω
    assert_allclose(ringing.max(), steady / found, rtol=0.02)
    assert_allclose(ringing[-200:].max(), ringing[:200].max(), rtol=0.02, err_msg="a spring does not lose energy")


@everywhere
def test_the_encoder_does_not_see_what_the_spring_gives_way(engine: str) -> None:
    plant = added(pendulum(), "joint_compliance", stiffness=20.0)
    plant = added(plant, "viscous_friction", coefficient=0.5)
    plant = added(plant, "constant_effort", effort=0.4)
    out = run(plant, 0.3, 4.0, engine=engine)
    stiffness = 5.0 * SUPPLY * TORQUE_CONSTANT / RESISTANCE
    transmitted = stiffness * (0.3 - out.position[-1, 0])
    link = out.position[-1, 0] - transmitted / 20.0
    assert_allclose(transmitted, MASS * 9.81 * LENGTH * np.sin(link) - 0.4, atol=1e-4)


@pytest.mark.parametrize("link_inertia", [4.5e-4, 0.05])
@pytest.mark.parametrize("stiffness", [5.0, 1e3, 1e6])
def test_compliance_is_stable_at_1_ms_with_light_links(link_inertia: float, stiffness: float) -> None:
    plant = wheel()
    links = (plant.model.links[0], Link("arm0", 1e-3, np.zeros(3), np.eye(3) * link_inertia))
    plant.model = replace(plant.model, links=links)
    plant.drive["viscous"] = 0.03
    rigid = run(plant, 0.5)
    out = run(added(plant, "joint_compliance", stiffness=stiffness), 0.5)
    assert np.abs(out.position).max() < 0.7
    assert_allclose(out.position[-1], 0.5, atol=0.1 if stiffness == 5.0 else 0.02)
    if stiffness == 1e6:
        assert_allclose(out.position, rigid.position, atol=2e-3)


@everywhere
def test_backlash_rests_in_its_dead_zone_and_lands_at_its_end(engine: str) -> None:
    """The motor pushes, lets go, and pulls: it crosses the whole width before the link moves the other way."""
    width, torque = 0.1, 0.3
    plant = added(effort_servo(wheel()), "backlash", angle=width)
    t = np.arange(2000) * 1e-3
    out = run(plant, np.where(t < 0.2, torque, -torque), 0.6, engine=engine)
    # from the middle, the free rotor crosses half of the width; the link rests meanwhile
    alone = torque / ARMATURE
    first = np.sqrt(width / alone)
    assert np.abs(out.position[out.time < first - 2 * H]).max() < AT_REST
    # an impact without rebound: the momentum is shared
    speed = alone * first * ARMATURE / (ARMATURE + LINK)
    landed = int(np.searchsorted(out.time, first)) + 3
    assert_allclose(out.velocity[landed, 0], speed + (out.time[landed] - first) * torque / (ARMATURE + LINK), rtol=0.02)
    # from 0.2 s on the rotor pulls back over the full width, while the link goes on at constant speed
    back = np.sqrt(2 * width / alone)
    free = (out.time > 0.2 + 3 * H) & (out.time < 0.2 + back - 3 * H)
    assert np.ptp(out.velocity[free, 0]) < 1e-6
    assert out.velocity[int(np.searchsorted(out.time, 0.2 + back)) + 3, 0] < out.velocity[free, 0].min() - 0.1


def test_play_takes_energy_and_keeps_momentum() -> None:
    """Rotor and link bounce to and fro in the dead zone: each impact shares the momentum and loses energy."""
    plant = added(effort_servo(wheel()), "backlash", angle=0.05)
    start, steps = State(np.zeros(1), np.array([2.0])), 400
    state, log = np.zeros(1, STATE), np.zeros((steps + 1, 1), LOG)
    state["velocity"] = 2.0
    q, w, base = np.zeros(1), np.zeros(1), np.zeros(13)
    law = [np.zeros(1) for _ in range(3)]
    link = []
    command, dry = np.zeros(1), np.zeros(1)
    with engines.load("mujoco").open(plant.machine(), Physics(H)) as simulation:
        simulation.reset(start)
        for k in range(steps):
            simulation.read(q, w, base)
            link.append(w[0])
            # the rotor rests at first: the state knows it before the first step
            if k == 0:
                state["begun"], state["mass"] = 1, ARMATURE
            drive_effort(plant.drive, state, command, command, q, w, dry, plant.inertia(), 0.0, k * H, H, *law, log[k])
            simulation.step(*law)
        simulation.read(q, w, base)
        arrive(plant.drive, state, q, w, dry, H, log[steps])
    rotor, moving = log["rotor"][:steps, 0], np.array(link)
    momentum = LINK * moving + ARMATURE * rotor
    assert_allclose(momentum, momentum[0], rtol=1e-9)
    energy = LINK * moving**2 + ARMATURE * rotor**2
    assert np.diff(energy).max() < 1e-9 * energy[0]
    assert_allclose(moving[-1], 2.0 * LINK / (LINK + ARMATURE), rtol=1e-3)


# motor and supply


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


@pytest.mark.parametrize("duties", [[1.0, 0.5], [0.3, -0.8], [-0.2, 0.1]])
def test_the_power_on_a_bus_is_balanced(duties: list[float]) -> None:
    """bus = supply - R_s·Σ volts·current/bus: what the servos take is what comes through the lead, either way."""
    plant = added(wheel(2), "voltage_sag", resistance=0.5)
    plant.drive["meaning"] = DUTY
    speed = np.array([2.0, 6.0])
    motor, bus = one_step(plant, np.array(duties), speed)
    power = np.array(duties) * bus * motor / TORQUE_CONSTANT
    assert_allclose(bus, SUPPLY - 0.5 * power.sum() / bus)
    assert (power.sum() < 0) == (bus[0] > SUPPLY), "a servo that brakes feeds back and lifts the bus"


def test_heating_lowers_torque_and_induced_voltage_over_time() -> None:
    plant = added(wheel(), "motor_heating", loss=0.02)
    plant.drive["meaning"] = DUTY
    for t in (0.0, 10.0, 30.0, 80.0):
        kt = TORQUE_CONSTANT * max(1 - 0.02 * t, 0.0)
        motor, _ = one_step(plant, np.ones(1), np.array([2.0]), t)
        assert_allclose(motor, kt / RESISTANCE * (SUPPLY - kt * 2.0), atol=1e-12)


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


# commands and sensors


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


def test_the_velocity_filter_is_a_low_pass_of_the_sensor_alone() -> None:
    plain = effort_servo(wheel())
    filtered = added(plain, "velocity_filter", time=0.05, scale=0.9)
    a, b = run(plain, 0.2), run(filtered, 0.2)
    assert_allclose(a.position, b.position, atol=0.0)
    slope = 0.2 / (LINK + ARMATURE)  # a ramp: the filter lags by its time constant
    assert_allclose(b.velocity[-1, 0], 0.9 * slope * (b.time[-1] + H / 2 - 0.05), rtol=2e-3)


# bodies and ground


@everywhere
def test_a_tilted_base_turns_gravity(engine: str) -> None:
    """Right-handed about x, then y: a free pendulum about y hangs at −pitch."""
    plant = added(pendulum(), "base_tilt", "base", roll=0.2, pitch=0.3)
    plant.drive["viscous"] = 0.25
    out = run(plant, np.nan, 4.0, engine=engine)
    gravity = (rotation_from_rpy(0.2, 0, 0) @ rotation_from_rpy(0, 0.3, 0)).T @ np.array([0.0, 0.0, -1.0])
    assert_allclose(out.position[-1, 0], np.arctan2(-gravity[0], -gravity[2]), atol=2e-4)


@everywhere
def test_a_payload_is_a_point_mass_at_its_place_beside_the_link(engine: str) -> None:
    """m·d² in the inertia, m·g·d in what holds the arm still; the link's own mass may change beside it."""
    plant = added(pendulum(), "payload", "arm0", mass=0.7, x=0.05, y=0.02, z=-0.3)
    plant = added(plant, "link_mass", "arm0", mass=0.8)
    own, state = plant.model.links[1], State(np.array([0.4]), np.zeros(1))
    with engines.load(engine).open(plant.machine().with_armature(np.zeros(1)), Physics(H)) as simulation:
        simulation.reset(state)
        mass, bias = float(simulation.mass_matrix()[0, 0]), float(simulation.bias()[0])
    arm = INERTIA + 0.8 * (own.com[0] ** 2 + own.com[2] ** 2)
    assert abs(mass - arm - 0.7 * (0.05**2 + 0.3**2)) < 1e-9
    gravity = 9.81 * (0.8 * own.com + 0.7 * np.array([0.05, 0.02, -0.3]))
    expected = -gravity[0] * np.cos(0.4) - gravity[2] * np.sin(0.4)
    assert abs(bias - expected) < 1e-6
    assert_allclose(holding_effort(plant, np.array([0.4])), [expected], atol=1e-6)


@everywhere
def test_mass_centre_and_inertia_reach_the_mass_matrix_exactly(engine: str) -> None:
    plant = added(pendulum(), "link_mass", "arm0", mass=0.8)
    plant = added(plant, "center_of_mass", "arm0", x=0.03, y=0.02, z=-0.2)
    plant = added(plant, "link_inertia", "arm0", scale=1.7)
    plant = added(plant, "rotor_inertia", armature=0.01)
    with engines.load(engine).open(plant.machine(), Physics(H)) as simulation:
        simulation.reset(State(np.array([0.4]), np.zeros(1)))
        found = simulation.mass_matrix()[0, 0]
        native = engines.load(engine).capabilities()["armature"].level == "native"
    expected = 0.8 * (0.03**2 + 0.2**2) + 1.7 * INERTIA
    assert min(abs(found - expected), abs(found - expected - 0.01)) < 1e-9
    assert not native or abs(found - expected - 0.01) < 1e-9
    # and the motion has all of it: torque over inertia
    plant = effort_servo(plant)
    plant.model = replace(plant.model, joints=(replace(plant.model.joints[0], axis=np.array([0.0, 0.0, 1.0])),))
    upright = 0.8 * (0.03**2 + 0.02**2) + 1.7 * INERTIA
    out = run(plant, 0.1, 0.2, engine=engine)
    assert_allclose(out.velocity[-1, 0], 0.1 / (upright + 0.01) * (out.time[-1] + H / 2), rtol=1e-6)


def block(ground: Ground) -> Plant:
    feet = tuple(Sphere(np.array([x, y, -0.01]), 0.01) for x in (-0.2, 0.2) for y in (-0.2, 0.2))
    model = Model("block", (Link("block", 1.2, np.zeros(3), np.eye(3) * 0.05, feet),), (), True)
    return Plant(model, neutral_drive(0), ground, *(np.zeros(0),) * 3, np.zeros(2))


def thrown(plant: Plant, engine: str, speed: float, duration: float) -> Trace:
    start = start_state(plant, np.zeros(0))
    start.base_linear = np.array([speed, 0.0, 0.0])
    with engines.load(engine).open(plant.machine(), Physics(H, ground=plant.ground)) as simulation:
        return rollout(simulation, plant, Commands(np.zeros(1), np.zeros((1, 0))), start, duration).trace


@everywhere
def test_the_ground_friction_is_that_of_the_pair(engine: str) -> None:
    out = thrown(added(block(Ground(0.8)), "ground_friction", "ground", coefficient=0.3), engine, 1.0, 0.6)
    assert_allclose(out.base_position[-1, 0], 1.0 / (2 * 0.3 * 9.81), rtol=0.02)


@everywhere
def test_a_soft_ground_sinks_by_weight_over_stiffness(engine: str) -> None:
    if engines.load(engine).capabilities()["soft_ground"].level == "no":
        pytest.skip(f"{engine} declares that it has no soft ground")
    plant = added(block(Ground(0.8)), "soft_ground", "ground", stiffness=1000.0, damping=20.0)
    out = thrown(plant, engine, 0.0, 1.5)
    depth = 0.02 - out.base_position[:, 2]
    assert_allclose(depth[-1], 1.2 * 9.81 / 4000.0, rtol=0.02)
    rate, decay = np.sqrt(4000.0 / 1.2), 80.0 / 1.2 / 2
    swing = np.sqrt(rate**2 - decay**2)
    t = out.time
    exact = 1.2 * 9.81 / 4000 * (1 - np.exp(-decay * t) * (np.cos(swing * t) + decay / swing * np.sin(swing * t)))
    assert np.abs(depth - exact).max() < 0.1 * 1.2 * 9.81 / 4000.0


def test_every_effect_of_the_design_is_there_in_its_order() -> None:
    """The order decides between explanations that are equal."""
    expected = """coulomb_friction viscous_friction stribeck_friction load_dependent_friction backlash joint_compliance
    rotor_inertia torque_constant torque_speed_limit supply_voltage voltage_sag command_delay controller_gain
    joint_offset torque_ripple motor_heating constant_effort link_mass center_of_mass link_inertia base_tilt
    ground_friction soft_ground velocity_filter payload dead_band joint_stop command_profile effort_limit
    direction_friction friction_ripple cable_spring motor_braking current_lag gain_law servo_rate"""
    assert list(EFFECTS) == expected.split()
