"""The command in force: held from message to message, and none where a controller fell silent."""

import numpy as np
import pytest
from realitygap.recording.commands import in_force
from realitygap.trace.trace import Array

PERIOD = 0.01


def sent(*stretches: tuple[float, float]) -> Array:
    """Times of a regular stream, in stretches from one time up to another [s]."""
    return np.concatenate([np.arange(round(a / PERIOD), round(b / PERIOD)) * PERIOD for a, b in stretches])


def force(time: Array, states: Array) -> tuple[Array, Array, list[str]]:
    """The commands k = 0, 1, 2, ... of one joint."""
    found, value, notes = in_force(time, np.arange(len(time), dtype=float)[:, None], None, states, ("a",))
    return found, value[:, 0], notes


def test_a_silent_stream_gives_no_command_from_one_period_after_its_last_message_on() -> None:
    time = sent((0.0, 1.0), (2.0, 3.0))
    found, value, notes = force(time, sent((0.0, 3.0)))
    (off,) = np.flatnonzero(np.isnan(value))
    assert found[[off - 1, off, off + 1]] == pytest.approx([0.99, 1.0, 2.0])
    assert notes == [
        "no command for all joints from 1.000 s until 2.000 s: the stream is silent, the servo taken as off"
    ]
    np.testing.assert_array_equal(np.delete(value, off), np.arange(len(time)))


def test_where_joint_states_pause_as_well_the_recorder_did() -> None:
    both = sent((0.0, 1.0), (2.0, 3.0))
    _, value, notes = force(both, both)
    assert np.isfinite(value).all()
    assert notes == []


def test_messages_that_come_when_something_happens_hold_however_long() -> None:
    """Four in a row, a tenth of a second of none, and at last a whole second."""
    time = np.concatenate([0.13 * k + PERIOD * np.arange(4) for k in range(10)] + [[2.5, 2.51]])
    _, value, notes = force(time, sent((0.0, 3.0)))
    assert np.isfinite(value).all()
    assert notes == []


@pytest.mark.parametrize(("first", "known"), [(0.15, True), (0.25, False)])
def test_a_first_command_holds_before_it_where_it_comes_soon(first: float, known: bool) -> None:
    found, value, _ = force(sent((first, 3.0)), sent((0.0, 3.0)))
    assert (found[0] == 0.0) == known
    assert value[0] == 0.0
    np.testing.assert_array_equal(value[int(known) :], np.arange(len(value) - known))
