"""Angles that begin again after a whole turn go on; what may be a motion stays as it was read."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from bags import EPOCH, FILE, STATE, scenario
from realitygap.recording import Recording, read_recording
from signals import Signals, there

TIME = 0.01 * np.arange(600)
TURN = 2.0 * np.pi


def wrapped(angle: Any) -> Any:
    return np.arctan2(np.sin(angle), np.cos(angle))


def swinging(late: float = 0.0) -> Any:
    """An angle that passes π forwards and backwards, with the noise of a sensor."""
    return 2.9 + 0.8 * np.sin(3.0 * (TIME - late)) + np.random.default_rng(0).normal(scale=1e-3, size=len(TIME))


def read(
    tmp_path: Path,
    position: Any,
    command: Any = None,
    time: Any = TIME,
    unit: str = "rad",
    limits: tuple[float, float] | None = None,
) -> Recording:
    columns = {"time": time, "position_a": position, **({} if command is None else {"command_a": command})}
    pd.DataFrame(columns).to_csv(tmp_path / "run.csv", index=False)
    asked = scenario(None, None, columns={"units": {"position": unit, "command": unit}})
    return read_recording(tmp_path / "run.csv", asked, ["a"], file=FILE, limits={"a": limits} if limits else None)


def told(recording: Recording) -> list[str]:
    return [note for note in recording.notes if "whole turn" in note]


@pytest.mark.parametrize("unit", ["rad", "deg"])
@pytest.mark.parametrize("low", [-np.pi, 0.0])
@pytest.mark.parametrize(("position", "command"), [(True, True), (True, False), (False, True)])
def test_angles_go_on_where_they_begin_again(
    position: bool, command: bool, low: float, unit: str, tmp_path: Path
) -> None:
    """Of an encoder from -π to π or from 0 to 2π, whichever side has it, and in degrees."""
    q, asked = swinging(0.04) + low + np.pi, swinging() + low + np.pi
    size = 180.0 / np.pi if unit == "deg" else 1.0

    def by_encoder(angle: Any) -> Any:
        return low + np.mod(angle - low, TURN)

    recording = read(
        tmp_path, size * (by_encoder(q) if position else q), size * (by_encoder(asked) if command else asked), unit=unit
    )
    trace = Signals(recording.trace)
    np.testing.assert_allclose(trace.position[:, 0], q, atol=1e-9)
    np.testing.assert_allclose(trace.command[:, 0], asked, atol=1e-9)
    assert len(told(recording)) == position + command
    assert not recording.outliers
    assert "as no motion does: its angle begins again there, and the turns are counted" in told(recording)[0]


def test_a_joint_that_goes_on_turning(tmp_path: Path) -> None:
    q = 9.0 * TIME
    recording = read(tmp_path, wrapped(q))
    np.testing.assert_allclose(Signals(recording.trace).position[:, 0], q, atol=1e-9)
    assert "position of a jumps by a whole turn 9 times (at 0.350, 1.050, 1.750, ... s)" in told(recording)[0]


def test_a_command_of_another_turn_is_that_of_the_position(tmp_path: Path) -> None:
    """The encoder is read just beyond π, where the command still stands just before it."""
    asked = swinging() + 0.3
    recording = read(tmp_path, wrapped(asked + 0.02), wrapped(asked))
    trace = Signals(recording.trace)
    np.testing.assert_allclose(trace.command, trace.position - 0.02, atol=1e-9)


def test_a_command_to_turn_once_is_none_of_an_encoder(tmp_path: Path) -> None:
    asked = np.where(TIME < 1.0, 0.0, TURN)
    q = TURN * np.clip((TIME - 1.0) / 2.0, 0.0, 1.0)
    recording = read(tmp_path, q, asked)
    np.testing.assert_array_equal(Signals(recording.trace).command[:, 0], asked)
    np.testing.assert_array_equal(Signals(recording.trace).position[:, 0], q)
    assert told(recording) == []


def stepping(*levels: float) -> tuple[Any, Any]:
    """A command that steps every second, and an angle that gets there within a few tenths."""
    asked = np.array(levels)[np.minimum((TIME + 1e-9).astype(int), len(levels) - 1)]
    q = np.empty_like(asked)
    q[0] = asked[0]
    for k in range(1, len(q)):
        q[k] = q[k - 1] + 0.1 * (asked[k - 1] - q[k - 1])
    return q, asked


@pytest.mark.parametrize("low", [-np.pi, 0.0])
@pytest.mark.parametrize(("position", "command"), [(True, True), (True, False), (False, True)])
def test_steps_across_the_end_of_a_turn_go_on(position: bool, command: bool, low: float, tmp_path: Path) -> None:
    """Such a step jumps by far less than a turn, or by more."""
    q, asked = stepping(3.0, 3.9, 2.4, 3.3, 4.6, 2.6)
    q, asked = q + low + np.pi - 3.0, asked + low + np.pi - 3.0

    def by_encoder(angle: Any) -> Any:
        return low + np.mod(angle - low, TURN)

    trace = Signals(read(tmp_path, by_encoder(q) if position else q, by_encoder(asked) if command else asked).trace)
    whole = TURN * np.rint((trace.position[0, 0] - q[0]) / TURN)
    np.testing.assert_allclose(trace.position[:, 0], q + whole, atol=1e-9)
    np.testing.assert_allclose(trace.command[:, 0], asked + whole, atol=1e-9)


@pytest.mark.parametrize("decimals", [2, 3, 4, 6])
def test_a_rounded_command_across_the_end_of_a_turn_goes_on(decimals: int, tmp_path: Path) -> None:
    """Rounded, it reaches further than a turn by some of its last digits."""
    asked = np.interp(TIME, [0.0, 2.0, 2.5, 4.0], [2.5, np.pi - 1e-5, np.pi + 1e-5, 4.2])
    inside = np.round(np.mod(asked + np.pi, TURN) - np.pi, decimals)
    trace = Signals(read(tmp_path, inside, inside).trace)
    np.testing.assert_allclose(trace.position[:, 0], asked, atol=10.0**-decimals)
    np.testing.assert_allclose(trace.command[:, 0], asked, atol=10.0**-decimals)


def test_a_long_step_within_a_turn_stays_so(tmp_path: Path) -> None:
    """By more than half a turn, in an encoder's range, of a joint that passes the end of it later."""
    q, asked = stepping(0.5, 5.5, 0.6, 5.0, 6.1, 6.6)
    trace = Signals(read(tmp_path, np.mod(q, TURN), np.mod(asked, TURN)).trace)
    np.testing.assert_allclose(trace.position[:, 0], q, atol=1e-9)
    np.testing.assert_allclose(trace.command[:, 0], asked, atol=1e-9)


def test_a_servo_that_is_off_at_first_is_told_of_the_turn_that_its_joint_is_in(tmp_path: Path) -> None:
    q, asked = stepping(3.0, 3.9, 2.4, 3.3, 4.6, 2.6)
    asked[TIME < 0.9] = np.nan
    trace = Signals(read(tmp_path, wrapped(q), wrapped(asked)).trace)
    np.testing.assert_allclose(trace.position[:, 0], q, atol=1e-9)
    np.testing.assert_allclose(trace.command[:, 0], asked, atol=1e-9)


def test_a_joint_that_takes_its_time_is_told_where_it_gets_to(tmp_path: Path) -> None:
    """For more than half of every step it is where it was before, nearly half a turn away."""
    q, asked = stepping(0.0, 3.3, 0.2, 3.4, 0.1, 3.3)
    late = np.concatenate([np.full(55, q[0]), q[:-55]])
    trace = Signals(read(tmp_path, wrapped(late), wrapped(asked)).trace)
    np.testing.assert_allclose(trace.position[:, 0], late, atol=1e-9)
    np.testing.assert_allclose(trace.command[:, 0], asked, atol=1e-9)


def test_a_commanded_effort_is_no_angle(tmp_path: Path) -> None:
    """6.3 N·m at a joint near zero is not a whole turn of it."""
    told = np.where(TIME < 3.0, TURN, -TURN)
    columns = {"time": TIME, "position_a": 0.01 * np.sin(TIME), "command_a": told}
    pd.DataFrame(columns).to_csv(tmp_path / "run.csv", index=False)
    recording = read_recording(tmp_path / "run.csv", scenario(None, "command", meaning="effort"), ["a"], file=FILE)
    np.testing.assert_allclose(recording.command[:, 0], told)


def test_a_joint_that_does_not_get_there_is_told_within_its_limits(tmp_path: Path) -> None:
    """The other end of its range is nearer to it by the way that it cannot go."""
    q, asked = stepping(0.3, -0.3, -2.5, 2.5, -2.5, 2.5)
    q = np.where(TIME < 3.0, q, -2.5)  # it is stuck there
    trace = Signals(read(tmp_path, np.mod(q, TURN), np.mod(asked, TURN), limits=(-2.6, 2.6)).trace)
    np.testing.assert_allclose(trace.position[:, 0], q, atol=1e-9)
    np.testing.assert_allclose(trace.command[:, 0], asked, atol=1e-9)


def test_steps_of_several_turns_are_left(tmp_path: Path) -> None:
    """Of a winch that takes longer for one than the next takes to come, and of which an encoder counts the turns."""
    asked = np.array([0.0, 2 * TURN, 0.0, TURN, 0.0, TURN])[np.minimum((TIME + 1e-9).astype(int), 5)]
    q = np.empty_like(asked)
    q[0] = asked[0]
    for k in range(1, len(q)):
        q[k] = q[k - 1] + np.clip(asked[k - 1] - q[k - 1], -0.03, 0.03)
    for position in (q, wrapped(q)):
        trace = Signals(read(tmp_path, position, asked).trace)
        np.testing.assert_allclose(trace.position[:, 0], q, atol=1e-9)
        np.testing.assert_array_equal(trace.command[:, 0], asked)


@pytest.mark.parametrize("turn", [-1, 1])
def test_a_joint_is_read_within_its_limits(turn: int, tmp_path: Path) -> None:
    """An encoder that never passes the end of its turn may be a whole one off, and so may be the command."""
    q = 0.5 * np.sin(3.0 * TIME)
    recording = read(tmp_path, q + turn * TURN, q + turn * TURN, limits=(-2.6, 2.6))
    np.testing.assert_allclose(Signals(recording.trace).position[:, 0], q, atol=1e-9)
    np.testing.assert_allclose(Signals(recording.trace).command[:, 0], q, atol=1e-9)
    above, lower = ("above", "lower") if turn > 0 else ("below", "higher")
    assert told(recording) == [
        f"the position of a was read a whole turn {above} its limits -2.6 and 2.6: taken a turn {lower}"
    ]


@pytest.mark.parametrize(
    ("position", "limits"),
    [
        (2.0 + np.sin(TIME), (-2.6, 2.6)),  # past a limit
        (6.0 + np.sin(TIME), (-0.3, 0.3)),  # no turn brings all of it there
        (4.0 + np.sin(TIME), (-4.0, 4.0)),  # most of it is there
        (57.3 * 0.5 * np.sin(TIME), (-2.6, 2.6)),  # in degrees
    ],
)
def test_what_no_turn_brings_within_the_limits_is_left(
    position: Any, limits: tuple[float, float], tmp_path: Path
) -> None:
    recording = read(tmp_path, position, position, limits=limits)
    np.testing.assert_allclose(Signals(recording.trace).position[:, 0], position, rtol=1e-12)
    np.testing.assert_allclose(Signals(recording.trace).command[:, 0], position, rtol=1e-12)
    assert told(recording) == []


def test_a_jump_across_a_pause_is_left_and_told(tmp_path: Path) -> None:
    kept = (TIME < 2.0) | (TIME > 4.0)
    q = 0.3 * np.sin(3.0 * TIME) + TURN * (TIME > 3.0)
    recording = read(tmp_path, q[kept], time=TIME[kept])
    np.testing.assert_array_equal(Signals(recording.trace).position[:, 0], q[kept])
    assert told(recording) == [
        "the position of a is a whole turn further after a pause (at 4.010 s): a motion, or an angle that begins "
        "again; taken as it was read"
    ]


@pytest.mark.parametrize(
    "position",
    [
        np.cumsum(np.where(np.arange(600) % 50 < 8, 1.0, 0.0)),  # a turn and more in eight readings
        3.0 * np.sign(np.sin(TIME)),  # another jump
        TURN * np.sin(9.0 * TIME),  # several turns, which the encoder counts itself
    ],
)
def test_a_motion_is_left(position: Any, tmp_path: Path) -> None:
    recording = read(tmp_path, position)
    np.testing.assert_allclose(Signals(recording.trace).position[:, 0], position, rtol=1e-12)
    assert told(recording) == []


def test_turns_are_counted_before_joints_of_several_publishers_are_interpolated(
    tmp_path: Path, write_bag: Callable[..., Path]
) -> None:
    messages = []
    for k, t in enumerate(TIME):
        arm = {"stamp": EPOCH + t, "name": ["b", "c"], "position": [float(k), 0.0]}
        turning = {"stamp": EPOCH + t + 0.004, "name": ["a"], "position": [wrapped(3.0 * t)]}
        messages += [("/joint_states", EPOCH + t, STATE, arm), ("/joint_states", EPOCH + t + 0.004, STATE, turning)]
    path = write_bag(tmp_path / "run", "mcap", messages)
    trace = read_recording(path, scenario(command=None), ["a", "b", "c"], file=FILE).trace
    assert len(trace.time) == len(TIME) - 1
    np.testing.assert_allclose(there(trace.position)[:, 0], 3.0 * (TIME[1:] - 0.004), atol=1e-5)
