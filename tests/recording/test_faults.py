"""Faults that are planted in a recording are found, with their numbers, and none where nothing was planted."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from realitygap.recording import Recording
from realitygap.recording.faults import (
    clock_drift,
    command_glitches,
    drift_between,
    faults,
    low_pass,
    repeated_readings,
    velocity_faults,
)
from realitygap.recording.outliers import without_outliers
from realitygap.trace.trace import Trace
from signals import Signals, there

PERIOD = 0.01
QUANTUM = 2 * np.pi / 4096


def recording(*, scale: float = 1.0, filter_time: float = 0.0, pace: float = 1.0, jitter: float = 0.1) -> Recording:
    """A swing of one joint as an encoder reads it, with a velocity as a servo reports it; a second joint rests."""
    rng = np.random.default_rng(0)
    time = np.arange(0.0, 20.0, PERIOD)
    time[1:] += jitter * PERIOD * rng.uniform(-0.5, 0.5, len(time) - 1)
    fine = np.arange(0.0, 20.0, 1e-3)
    phase = pace * fine
    angle = np.sin(2 * phase) + 0.3 * np.sin(5 * phase + 1) + 0.2 * np.sin(0.3 * phase**2)
    slope = scale * low_pass(np.gradient(angle, fine), filter_time, 1e-3)
    position = np.round(np.interp(time, fine, angle) / QUANTUM) * QUANTUM
    velocity = np.round(np.interp(time, fine, slope) / 0.02) * 0.02
    still = np.zeros_like(time)
    command = np.column_stack([np.interp(time + 0.03, fine, angle), still])
    trace = Trace(
        time,
        ("swing", "rest"),
        position=np.column_stack([position, still]),
        velocity=np.column_stack([velocity, still]),
        command=command,
    )
    return Recording(Path("run.mcap"), trace, time, command, "position", np.empty(0), np.empty(0), time.copy())


def test_a_sound_recording_has_no_faults() -> None:
    assert faults(recording()) == []


@pytest.mark.parametrize("count", [34, 60])
def test_the_noise_of_a_joint_at_rest_is_no_velocity_of_a_sensor(count: int) -> None:
    rng = np.random.default_rng(count)
    trace, time = recording().trace, np.arange(count) / 200
    for _ in range(30):
        position, velocity = (np.round(rng.normal(0.0, s, (count, 2)), 6) for s in (3e-4, 5e-3))
        still = replace(trace, time=time, position=position, velocity=velocity, command=None)
        assert velocity_faults(replace(recording(), trace=still)) == []


@pytest.mark.parametrize(
    ("scale", "time"), [(0.89, 0.0), (1.1, 0.0), (1.0, 0.02), (0.91, 0.014), (1.0, 0.05), (0.95, 0.03)]
)
def test_a_velocity_that_is_scaled_and_filtered(scale: float, time: float) -> None:
    (fault,) = velocity_faults(recording(scale=scale, filter_time=time))
    assert fault.joints == ("swing",)
    assert fault.sentence.startswith("the reported velocity of swing is ")
    assert ("low-passed with" in fault.sentence) == (time > 0.0)
    assert "medians" not in fault.sentence
    assert fault.numbers["scale"] == pytest.approx(scale, abs=0.01)
    assert fault.numbers["time"] == pytest.approx(time, abs=0.002)
    assert "the sensor, not the robot" in fault.sentence


@pytest.mark.parametrize("time", [0.0131, 0.0147, 0.0209])
def test_the_time_of_a_filter_is_told_finer_than_it_is_tried(time: float) -> None:
    (fault,) = velocity_faults(recording(filter_time=time))
    assert fault.numbers["time"] == pytest.approx(time, abs=3e-4)


def test_a_velocity_of_the_wrong_sign() -> None:
    (fault,) = velocity_faults(recording(scale=-1.0))
    assert fault.numbers["scale"] == pytest.approx(-1.0, abs=0.01)


@pytest.mark.parametrize("count", [1, 5])
def test_repeated_readings(count: int) -> None:
    sound = recording()
    position, velocity = Signals(sound.trace).position.copy(), Signals(sound.trace).velocity.copy()
    steps = np.diff(position[:, 0])
    fast = 2 + np.flatnonzero((np.abs(steps[:-3]) > 4 * QUANTUM) & (np.abs(steps[3:]) > 4 * QUANTUM))
    for row in fast[50 :: len(fast) // count][:count]:
        position[row], velocity[row] = position[row - 1], velocity[row - 1]
    found = there(repeated_readings(replace(sound, trace=replace(sound.trace, position=position, velocity=velocity))))
    assert found.joints == ("swing",)
    assert found.numbers["count"] == count
    moving = round(count / found.numbers["share"])
    repeat = "repeats the one before it" if count == 1 else "repeat the one before them"
    assert found.sentence == f"{count} of {moving} readings in motion {repeat}, in swing: the bus, not the robot"


@pytest.mark.parametrize("noise", [0.0, 0.5, 1.0, 2.0])
def test_slow_readings_are_equal_by_chance(noise: float) -> None:
    """Steps of some quanta beside noise of as many: no bus repeats them, and nothing is said of one."""
    rng, time = np.random.default_rng(3), np.arange(0.0, 40.0, PERIOD)
    angle = 0.3 * np.sin(1.5 * time) + noise * QUANTUM * rng.standard_normal(len(time))
    position = np.column_stack([np.round(angle / QUANTUM) * QUANTUM, np.zeros_like(time)])
    sound = recording()
    assert repeated_readings(replace(sound, trace=Trace(time, ("swing", "rest"), position=position))) is None


def test_a_joint_at_rest_repeats_its_reading_rightly() -> None:
    sound = recording()
    still = replace(sound.trace, position=np.zeros((2000, 2)), velocity=np.zeros((2000, 2)))
    assert repeated_readings(replace(sound, trace=still)) is None


@pytest.mark.parametrize("size", [0.3, -0.6])
def test_a_single_command_that_jumps_and_comes_back(size: float) -> None:
    sound = recording()
    command = sound.command.copy()
    command[812] += [size, -size]
    (fault,) = command_glitches(replace(sound, command=command))
    assert fault.joints == ("swing", "rest")
    assert fault.numbers["time"] == pytest.approx(sound.command_time[812])
    assert fault.numbers["size"] == pytest.approx(abs(size), abs=0.05)


def test_a_glitch_of_one_joint_is_said_in_the_singular() -> None:
    sound = recording()
    command = sound.command.copy()
    command[812, 0] += 0.3
    (fault,) = command_glitches(replace(sound, command=command))
    assert "and back in 1 joint (swing): " in fault.sentence


@pytest.mark.parametrize("kind", ["effort", "velocity", "duty"])
def test_what_a_controller_asks_for_jumps_as_it_is_meant_to(kind: str) -> None:
    sound = recording()
    command = sound.command.copy()
    command[812] += 0.3
    assert command_glitches(replace(sound, command=command, command_kind=kind)) == []


def test_a_fast_sine_turns_without_a_glitch() -> None:
    sound = recording()
    sine = np.sin(2.0 * np.pi * 5.0 * 0.02 * np.arange(len(sound.command_time)))[:, None]
    assert command_glitches(replace(sound, command=np.broadcast_to(sine, sound.command.shape))) == []


def test_a_step_is_not_a_glitch() -> None:
    sound = recording()
    command = sound.command.copy()
    command[812:] += 0.5
    command[900:] = np.nan
    assert command_glitches(replace(sound, command=command)) == []


@pytest.mark.parametrize(
    ("signal", "joint", "value"),
    [("velocity", 0, -381.95), ("velocity", 1, 40.0), ("position", 0, 12), ("position", 0, 1e300)],
)
def test_a_reading_that_no_motion_explains_is_taken_out_and_told(signal: str, joint: int, value: float) -> None:
    sound = recording()
    garbled = getattr(sound.trace, signal).copy()
    garbled[730, joint] = value
    changed: dict[str, Any] = {signal: garbled}
    trace, outliers = without_outliers(replace(sound.trace, **changed))
    (fault,) = faults(replace(sound, trace=trace, outliers=outliers))
    assert fault.kind == "outlier"
    assert f"1 {signal} reading of {sound.trace.joints[joint]} jumps far away and back" in fault.sentence
    unit = {"position": "rad", "velocity": "rad/s"}[signal]
    assert f"({value:.4g} at {sound.trace.time[730]:.3f} s) in {unit}, of a slide" in fault.sentence
    mended, before = getattr(trace, signal), getattr(sound.trace, signal)
    assert mended[730, joint] == pytest.approx(before[[729, 731], joint].mean())
    assert np.array_equal(np.delete(mended, 730, axis=0), np.delete(before, 730, axis=0))


@pytest.mark.parametrize(
    "bad",
    [
        {730: -999.0, 732: -999.0},
        {730: -999.0, 732: -999.0, 734: -999.0},
        {730: -999.0, 731: 65535.0},
        {730: -999.0, 731: 65535.0, 733: -999.0},
    ],
    ids=str,
)
def test_a_sound_reading_between_outliers_keeps_its_value(bad: dict[int, float]) -> None:
    sound, rows = recording(), [*bad]
    garbled = Signals(sound.trace).position.copy()
    garbled[rows, 0] = [*bad.values()]
    trace, outliers = without_outliers(replace(sound.trace, position=garbled))
    assert [o.time for o in outliers] == sound.trace.time[rows].tolist()
    mended, before = Signals(trace).position, Signals(sound.trace).position
    kept = np.setdiff1d(np.arange(len(before)), rows)
    np.testing.assert_array_equal(mended[kept], before[kept])
    np.testing.assert_allclose(mended[rows, 0], np.interp(rows, kept, before[kept, 0]))


def test_an_impact_is_not_an_outlier() -> None:
    """One reading of a speed that the positions before and after bear out, amid the sensor's noise."""
    sound = recording()
    velocity = 0.02 * np.random.default_rng(4).integers(-1, 2, (2000, 2)).astype(np.float64)
    velocity[1000] = 20.0
    borne_out, still = np.zeros((2000, 2)), np.zeros((2000, 2))
    borne_out[1000:] = 0.2
    trace = replace(sound.trace, position=borne_out, velocity=velocity)
    assert without_outliers(trace) == (trace, ())
    assert len(without_outliers(replace(trace, position=still))[1]) == 2, "the same reading where nothing moved"


def test_noise_is_no_outlier() -> None:
    sound = recording()
    noise = np.random.default_rng(3).standard_normal((2000, 2))
    trace = replace(sound.trace, position=Signals(sound.trace).position + 1e-3 * noise, velocity=0.5 * noise)
    assert without_outliers(trace)[1] == ()


@pytest.mark.parametrize("rate", [2e-3, -1e-3])
def test_a_recorder_and_stamps_that_run_apart(rate: float) -> None:
    sound = recording()
    delays = np.abs(np.random.default_rng(1).normal(size=2000)) * 2e-3
    fault = there(clock_drift(replace(sound, receive_time=(1 + rate) * sound.trace.time + delays)))
    assert fault.numbers["rate"] == pytest.approx(rate, rel=0.1)
    assert ("slower" if rate > 0 else "faster") in fault.sentence
    assert clock_drift(replace(sound, receive_time=sound.trace.time + delays)) is None


@pytest.mark.parametrize("rate", [3e-3, -2e-3])
def test_repetitions_whose_clocks_run_apart(rate: float) -> None:
    reference = recording(jitter=0.0)
    fault = there(drift_between(reference, recording(pace=1.0 / (1.0 + rate), jitter=0.0)))
    assert fault.numbers["rate"] == pytest.approx(rate, rel=0.25)
    assert f"% {'faster' if rate > 0 else 'slower'} than that of" in fault.sentence
    assert drift_between(reference, recording()) is None


def test_a_garbled_reading_of_a_robot_of_one_joint_is_no_size_of_its_quantum() -> None:
    time = np.linspace(0.0, 5.0, 500)
    position = np.round(np.sin(time) * 4096)[:, None] / 4096
    position[200] = 1e300
    (outlier,) = without_outliers(Trace(time, ("elbow",), position=position))[1]
    assert outlier.time == time[200]
