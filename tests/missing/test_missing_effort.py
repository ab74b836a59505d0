"""What is planted in a simulation and missing in the model lies in the band of the missing effort, in every engine."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
import realitygap as rg
import yaml
from numpy.testing import assert_allclose
from one_joint import LENGTH, LINK, MASS, added, everywhere
from realitygap.missing.effort import MissingEffort, since_reversal, variables_of
from realitygap.missing.files import ADDED, as_trace, of_trace, write_told
from realitygap.missing.followed import lacking_followed
from realitygap.missing.shape import shape_of
from realitygap.missing.words import sentence
from realitygap.robot.plant import Plant
from realitygap.simulate.follow import Followed
from realitygap.simulate.start import start_state
from realitygap.trace.trace import Array
from realitygap_engines import GRAVITY
from swings import H, arm, chirp, ramps, recovered, sines, steps, swing

WEIGHT = MASS * GRAVITY * LENGTH


@dataclass(frozen=True)
class Moved:
    """Reading, speed and acceleration [rad, s]."""

    q: Array
    v: Array
    a: Array


PLANTED: dict[str, tuple[Plant, Callable[[Moved], Array]]] = {
    "friction": (added(arm(), "coulomb_friction", torque=0.25), lambda m: -0.25 * np.sign(m.v)),
    "damping": (added(arm(), "viscous_friction", coefficient=0.1), lambda m: -0.1 * m.v),
    "load": (arm(1.5), lambda m: -0.5 * (WEIGHT * np.sin(m.q) + MASS * LENGTH**2 * m.a)),
    "ripple": (
        added(arm(), "torque_ripple", amplitude=0.15, periods=14.0, phase=0.3),
        lambda m: -0.15 * np.sin(14 * m.q + 0.3),
    ),
    "constant": (added(arm(), "constant_effort", effort=0.2), lambda m: np.full_like(m.q, 0.2)),
    "offset": (added(arm(), "joint_offset", angle=0.15), lambda m: WEIGHT * (np.sin(m.q) - np.sin(m.q + 0.15))),
    "nothing": (arm(), lambda m: np.zeros_like(m.q)),
}
"""What is real, and by its reading, speed and acceleration what the plain arm lacks [N·m]."""


def held(name: str, engine: str = "mujoco", rate: float = 200.0) -> tuple[float, float, float]:
    """How often the band holds what was planted, half of its width in the median, and the planted size [N·m]."""
    real, truth = PLANTED[name]
    commands, trace = swing(real, chirp, engine=engine, rate=rate)
    found = recovered(arm(), commands, trace, engine=engine)
    assert trace.position is not None
    assert trace.velocity is not None
    q, v = trace.position[:, 0], trace.velocity[:, 0]
    at = np.searchsorted(trace.time, commands.time)
    planted = truth(Moved(q, v, np.gradient(v, H)))[at]
    low, high = found.band
    inside = (low[:, 0] <= planted) & (planted <= high[:, 0])
    half = float(np.median(high - low)) / 2
    return float(np.mean(inside[np.abs(v[at]) > 0.02])), half, float(np.sqrt(np.mean(planted**2)))


@everywhere
@pytest.mark.parametrize("name", PLANTED)
def test_the_band_holds_what_was_planted(name: str, engine: str) -> None:
    share, half, size = held(name, engine)
    assert share >= 0.9
    assert half < (0.03 if name == "nothing" else size)


@pytest.mark.parametrize("rate", [50.0, 100.0, 1000.0])
def test_the_band_holds_it_at_every_rate_of_readings(rate: float) -> None:
    for name in ("friction", "ripple", "constant"):
        share, half, size = held(name, rate=rate)
        assert share >= 0.9
        assert half < size


def test_friction_that_the_model_has_holds_a_joint_at_rest_and_nothing_is_missing() -> None:
    plant = added(arm(), "coulomb_friction", torque=0.3)
    commands, trace = swing(plant, lambda t: np.where(t < 1.0, 0.0, 0.2), lasts=4.0)
    found = recovered(plant, commands, trace)
    rest = commands.time > 2.0
    assert trace.velocity is not None
    assert np.abs(trace.velocity[2000:]).max() < 1e-5
    assert np.abs(found.effort[rest]).max() < 0.02
    assert np.median(found.error[rest]) == pytest.approx(0.3 / np.sqrt(3), rel=0.05), "anything within the bound"


@everywhere
def test_of_a_followed_motion_it_is_what_the_measured_effort_has_less(engine: str) -> None:
    real = added(added(arm(), "coulomb_friction", torque=0.2), "constant_effort", effort=0.1)
    commands, trace = swing(real, lambda t: np.sin(2 * t))
    at = trace.at(commands.time)
    assert at.position is not None
    assert at.velocity is not None
    assert at.effort is not None
    noise = np.random.default_rng(0).normal(size=at.effort.shape)
    plant = arm()
    start = start_state(plant, at.position[0])
    found = lacking_followed(
        engine, plant, Followed(at.time, at.position), start, at.effort + 0.05 * noise, of_joint=False
    )
    moving = np.abs(at.velocity[:, 0]) > 0.1
    miss = found.effort[moving, 0] - (0.1 - 0.2 * np.sign(at.velocity[moving, 0]))
    assert np.mean(np.abs(miss) < 1.96 * found.error[moving, 0]) >= 0.9
    assert np.median(found.error) < 0.06
    assert_allclose(found.load[moving, 0], (WEIGHT * np.sin(at.position) + LINK * found_acceleration(trace))[moving, 0],
                    atol=0.1)  # fmt: skip


def found_acceleration(trace: rg.Trace) -> Array:
    assert trace.velocity is not None
    return np.gradient(trace.velocity, H, axis=0)[::5]


def test_a_temperature_that_was_recorded_is_what_a_drag_depends_on_and_no_effect(tmp_path: Path) -> None:
    """Grease that thins as it warms: the drag falls from 0.5 to 0.1 N·m, whatever the motion."""
    runs = []
    for k, motion in enumerate((chirp, sines, ramps, steps)):
        time = np.arange(0.0, 10.0, 1 / 100)
        warm = 30.0 + 15.0 * np.sin(0.9 * time + k)[:, None]
        angle = motion(time)[:, None]
        speed = np.gradient(angle, time, axis=0)
        drag = 0.1 + 0.4 * np.exp(-((warm - 15.0) / 12.0))
        noise = 0.01 * np.random.default_rng(k).normal(size=angle.shape)
        variables = variables_of(time, angle, speed, np.sin(angle), None, None, warm)
        found = MissingEffort(
            str(k), "mujoco", None, ("joint0",), (False,), time, drag + noise, 0 * drag + 0.01, variables
        )
        runs.append(found)
        assert_allclose(of_trace("", "mujoco", as_trace(found), ()).variables["temperature"], warm)
    shape = shape_of(runs, "joint0")
    assert [term.variables for term in shape.terms] == [("temperature",)]
    assert shape.share > 0.9
    assert "depends on the temperature" in sentence(shape)
    assert not shape.effects
    write_told(tmp_path, "mujoco", [shape])
    written = (tmp_path / ADDED).read_text()
    assert "no simulation knows the temperature" in written
    assert yaml.safe_load(written) == {"effects": []}


def test_the_time_since_a_reversal_begins_anew_at_each_and_not_at_a_rest() -> None:
    time = np.arange(0.0, 6.0, 1.0)
    assert_allclose(since_reversal(time, np.array([1.0, 0.0, 1.0, -1.0, 0.001, -1.0])), [0, 1, 2, 0, 1, 2])
    assert_allclose(since_reversal(time, np.zeros(6)), time)


def test_the_error_is_what_is_commanded_less_the_reading_and_none_where_a_servo_is_off() -> None:
    time, reading = np.arange(3.0), np.array([[0.1, 1.0], [0.2, 1.0], [0.3, 1.0]])
    command = np.array([[0.4, 0.5], [0.4, np.nan], [0.1, 1.0]])
    found = variables_of(time, reading, np.ones((3, 2)), reading, command, np.array([12.0, 11.0, 10.0]), None)
    assert_allclose(found["error"], [[0.3, -0.5], [0.2, 0.0], [-0.2, 0.0]])
    assert_allclose(found["supply"], [[12.0, 12.0], [11.0, 11.0], [10.0, 10.0]])


def test_the_load_is_what_moving_the_links_takes_where_they_really_are() -> None:
    """Without the rotor, at the angle beyond the reading by the offset, which the model has as it has the friction."""
    plant = added(added(arm(), "joint_offset", angle=0.4), "coulomb_friction", torque=0.3)
    commands, trace = swing(plant, sines)
    found = recovered(plant, commands, trace)
    assert trace.position is not None
    assert trace.velocity is not None
    at = np.searchsorted(trace.time, commands.time)
    expected = WEIGHT * np.sin(trace.position + 0.4) + LINK * np.gradient(trace.velocity, H, axis=0)
    miss = found.variables["load"][50:-50, 0] - expected[at][50:-50, 0]
    assert np.sqrt(np.mean(miss**2)) < 0.02
    assert np.sqrt(np.mean(found.effort**2)) < 0.05, "nothing is missing"
