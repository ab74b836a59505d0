"""Efforts that depend on measured variables, against what a pencil says, in every engine."""

import numpy as np
import pytest
import realitygap_engines as engines
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
    pendulum,
    run,
    slider,
    wheel,
)
from realitygap.cli import effects_page
from realitygap.files.errors import InputError
from realitygap.robot.drive import LOG, STATE
from realitygap.robot.drive_law import drive_effort
from realitygap.robot.effects import EFFECTS, EFFORT_MAP, WRITABLE
from realitygap.robot.effort_map import VARIABLES, packed
from realitygap.robot.law import effort_map as law
from realitygap.robot.plant import Plant
from realitygap.simulate.effect_bench import arm, planted, simulate
from signals import Signals

WHOLE = LINK + ARMATURE
DC_GAIN = 5.0 * SUPPLY * TORQUE_CONSTANT / RESISTANCE


def mapped(plant: Plant, variables: list[str], knots: list[list[float]], values: object) -> Plant:
    return added(plant, "effort_map", variables=variables, knots=knots, values=values)  # type: ignore[arg-type]


@everywhere
def test_a_map_of_zeros_changes_nothing_bit_for_bit(engine: str) -> None:
    for variables in (["speed"], ["angle", "speed"], ["load", "error"]):
        knots = [[-0.3, 0.2, 0.7]] * len(variables)
        values = [0.0] * 3 if len(variables) == 1 else [[0.0] * 3] * 3
        out, bare = (simulate(p, engine, duration=0.5) for p in (mapped(arm(), variables, knots, values), arm()))
        assert np.array_equal(Signals(out).position, Signals(bare).position)


@everywhere
def test_a_map_over_the_angle_is_a_spring_within_its_knots_and_constant_beyond(engine: str) -> None:
    plant = mapped(effort_servo(wheel()), ["angle"], [[-0.5, 0.5]], [1.0, -1.0])
    out = run(plant, 0.0, 3.0, engine=engine, position=0.2)
    crossings = out.time[1:][(out.position[:-1, 0] < 0) & (out.position[1:, 0] >= 0)]
    assert_allclose(2 * np.pi / np.diff(crossings).mean(), np.sqrt(2.0 / WHOLE), rtol=1e-3)
    beyond = run(plant, 0.0, 0.05, engine=engine, position=2.0)
    assert_allclose(beyond.velocity[:, 0], -1.0 / WHOLE * (beyond.time + H / 2), rtol=1e-5, atol=1e-5)


@everywhere
def test_a_map_over_the_speed_is_damping(engine: str) -> None:
    plant = mapped(effort_servo(wheel()), ["speed"], [[-10.0, 10.0]], [4.0, -4.0])
    same = added(effort_servo(wheel()), "viscous_friction", coefficient=0.4)
    a, b = (run(p, 0.0, 0.3, engine=engine, velocity=2.0).velocity for p in (plant, same))
    assert_allclose(a, b, rtol=1e-9)


def test_a_steep_fall_with_the_speed_is_stable_on_a_light_joint() -> None:
    """A thousandth of the wheel's inertia, and all of a dry friction within 0.02 rad/s."""
    plant = slider(5e-5)
    plant.drive["armature"] = 0.0
    plant = mapped(effort_servo(plant), ["speed"], [[-0.01, 0.01]], [0.3, -0.3])
    out = run(plant, 0.1, 0.3, velocity=0.5)
    assert_allclose(out.velocity[-100:, 0], 0.1 / 30.0, rtol=1e-6)


def test_of_two_variables_it_is_bilinear() -> None:
    values = [[0.1, 0.2], [0.5, -0.3], [0.0, 0.4]]
    plant = mapped(effort_servo(wheel()), ["angle", "speed"], [[-1.0, 0.0, 1.0], [-2.0, 2.0]], values)
    for q, w in ((-0.5, 1.0), (0.25, -1.5), (0.6, 0.0), (3.0, 9.0)):
        x, y = np.clip(q, -1, 1), (np.clip(w, -2, 2) + 2) / 4
        ends = [np.interp(x, [-1, 0, 1], [row[k] for row in values]) for k in (0, 1)]
        out = run(plant, 0.0, 2 * H, position=q, velocity=w)
        expected = (1 - y) * ends[0] + y * ends[1]
        assert_allclose((2 * out.velocity[0, 0] - 2 * w) / H * WHOLE, expected, atol=6e-3)


@everywhere
def test_it_can_depend_on_the_error_the_load_and_the_supply(engine: str) -> None:
    """At rest: the error is what the servo's gain answers, the load is gravity's."""
    plant = pendulum()
    plant.drive["viscous"] = 0.2
    weight = MASS * 9.81 * LENGTH
    error = mapped(plant, ["error"], [[-1.0, 1.0]], [-2.0, 2.0])
    q = run(error, 0.3, 3.0, engine=engine).position[-1, 0]
    assert_allclose((DC_GAIN + 2.0) * (0.3 - q), weight * np.sin(q), atol=1e-5)
    load = mapped(plant, ["load"], [[-10.0, 10.0]], [1.0, -1.0])
    q = run(load, 0.3, 3.0, engine=engine).position[-1, 0]
    motor = DC_GAIN * (0.3 - q)
    assert_allclose(motor, 1.1 * weight * np.sin(q), atol=1e-5)
    supply = mapped(plant, ["supply"], [[10.0, 20.0]], [0.0, 1.0])
    q = run(supply, 0.3, 3.0, engine=engine).position[-1, 0]
    assert_allclose(DC_GAIN * (0.3 - q) + 0.5, weight * np.sin(q), atol=1e-5)


def test_it_can_depend_on_the_time_since_the_last_reversal() -> None:
    """Pushed for 0.2 s after each reversal of a wheel that a cable swings to and fro."""
    plant = added(effort_servo(wheel()), "cable_spring", stiffness=WHOLE * 36.0)
    plain = run(plant, 0.0, 1.2, position=0.3)
    out = run(mapped(plant, ["reversal"], [[0.1, 0.1 + 1e-9]], [0.05, 0.0]), 0.0, 1.2, position=0.3)
    extra = np.gradient(out.velocity[:, 0], H) + 36.0 * out.position[:, 0]
    reversals = [0.0, *plain.time[1:][np.diff(np.sign(plain.velocity[:, 0])) != 0]]
    since = np.array([t - max(r for r in reversals if r <= t + 1e-9) for t in out.time])
    assert_allclose(extra[(since > 0.02) & (since < 0.08)] * WHOLE, 0.05, atol=5e-3)
    assert_allclose(extra[(since > 0.15) & (since < 0.4)] * WHOLE, 0.0, atol=5e-3)


def test_the_supply_that_was_recorded_is_the_one_it_depends_on() -> None:
    """Also of a servo whose own supply is stated."""
    plant = mapped(wheel(), ["supply"], [[10.0, 20.0]], [0.0, 1.0])
    assert given_at(plant, recorded=12.0) == pytest.approx(0.2)
    assert given_at(plant, recorded=0.0) == pytest.approx((SUPPLY - 10.0) / 10.0)


def given_at(plant: Plant, recorded: float) -> float:
    """What the maps of a wheel at rest, at its goal, add to its effort."""
    numbers, zero = packed(plant.maps), np.zeros(1)
    state, log = np.zeros(1, STATE), np.zeros(1, LOG)
    terms = [np.zeros(1) for _ in range(3)]
    at = plant.inertia(), recorded, 0.0, H
    drive_effort(plant.drive, state, zero, zero, zero, zero, zero, *at, *terms, log)
    law.add_mapped(*numbers, plant.drive, state, zero, zero, *at, *terms[:2], log)
    return float(terms[0][0])


def test_along_a_motion_that_begins_at_rest_no_reversal_was_before_it() -> None:
    """The time counts from the beginning, and anew from the one reversal, 0.6 s later."""
    time = H * np.arange(1000)
    velocity = np.where(time < 0.2, 0.0, np.where(time < 0.6, 1.0, -1.0))[:, None]
    plant, none, out = mapped(wheel(), ["reversal"], [[0.0, 1.0]], [0.0, 1.0]), np.zeros((1000, 1)), np.zeros((1000, 1))
    law.map_along(*packed(plant.maps), time, none, velocity, none, np.zeros(1000), out)
    assert_allclose(-out[:, 0], np.where(time < 0.6, time, time - 0.6), atol=1e-12)


def test_the_codes_are_the_variables_in_order() -> None:
    assert [getattr(law, name.upper()) for name in VARIABLES] == list(range(len(VARIABLES)))


def test_every_joint_of_a_target_gets_it_and_no_other() -> None:
    plant = added(
        effort_servo(wheel(3)),
        "effort_map",
        ["joint0", "joint2"],  # type: ignore[arg-type]
        variables=["angle"],  # type: ignore[arg-type]
        knots=[[0.0]],  # type: ignore[arg-type]
        values=[0.2],  # type: ignore[arg-type]
    )
    speed = run(plant, 0.0, 0.1).velocity[-1]
    assert_allclose(speed, [speed[0], 0.0, speed[0]])
    assert_allclose(speed[0], 0.2 / WHOLE * 0.1, rtol=0.02)


def test_engines_agree_to_rounding() -> None:
    traces = []
    for engine in engines.available():
        plant = planted(EFFORT_MAP)
        plant.drive["coulomb"] = plant.drive["static"] = 0.0
        traces.append(Signals(simulate(plant, engine, duration=0.8)).position)
    for engine, other in zip(engines.available()[1:], traces[1:], strict=True):
        exact = engines.load(engine).capabilities()["forward_dynamics"].level != "no"
        assert np.abs(other - traces[0]).max() < (1e-8 if exact else 1e-6)


def test_its_page_is_there_and_it_is_no_law() -> None:
    assert "effort_map" not in EFFECTS
    assert list(WRITABLE) == [*EFFECTS, "effort_map"]
    text = effects_page.page("effort_map")
    assert "{effect: effort_map, target: left_knee, variables: [angle], knots: [[-0.5, 0, 0.5]]" in " ".join(
        text.split()
    )
    assert "effort_map" in effects_page.table()


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"variables": ["angle"], "knots": [[0, 1]]}, "values"),
        ({"variables": ["angle"], "knots": [[0, 1]], "values": [1, 2], "scale": 2}, "scale"),
        ({"variables": ["angel"], "knots": [[0, 1]], "values": [1, 2]}, "angle"),
        ({"variables": "angle", "knots": [[0, 1]], "values": [1, 2]}, "one or two"),
        ({"variables": ["angle", "angle"], "knots": [[0, 1]] * 2, "values": [[1, 2]] * 2}, "one or two"),
        ({"variables": ["angle", "speed", "load"], "knots": [[0]] * 3, "values": [1]}, "one or two"),
        ({"variables": ["angle"], "knots": [0, 1], "values": [1, 2]}, "list of numbers"),
        ({"variables": ["angle"], "knots": [[0, 1], [0, 1]], "values": [1, 2]}, "each of 1"),
        ({"variables": ["angle"], "knots": [[1, 0]], "values": [1, 2]}, "increas"),
        ({"variables": ["angle"], "knots": [[0, 1]], "values": [1, 2, 3]}, "expected 2 numbers"),
        ({"variables": ["angle", "speed"], "knots": [[0, 1], [0, 1, 2]], "values": [[1, 2], [3, 4]]}, "2 x 3"),
        ({"variables": ["angle", "speed"], "knots": [[0, 1], [0, 1]], "values": 4}, "rows"),
        ({"variables": ["angle"], "knots": [[0, float("nan")]], "values": [1, 2]}, "list of numbers"),
        ({"variables": ["angle"], "knots": [[]], "values": []}, "list of numbers"),
    ],
)
def test_bad_input_is_told_in_one_sentence(given: dict[str, object], told: str) -> None:
    with pytest.raises(InputError) as error:
        added(wheel(), "effort_map", **given)  # type: ignore[arg-type]
    assert told in str(error.value)
    assert "\n" not in str(error.value)
