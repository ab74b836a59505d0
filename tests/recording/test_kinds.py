"""Messages of one topic that name different joints, as those of several publishers, are merged joint by joint."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bags import EPOCH, FILE, FORMS, STATE, scenario
from realitygap.recording import Recording, read_recording
from signals import Signals

Message = tuple[str, float, str, dict[str, Any]]


def joint(name: str, time: float, position: float, topic: str = "/joint_states", late: float = 0.0) -> Message:
    """One joint by itself, received `late` after its stamp."""
    fields = {"stamp": EPOCH + time, "name": [name], "position": [position], "velocity": [2.0 * position]}
    return topic, EPOCH + time + late, STATE, fields


def read(path: Path, joints: tuple[str, ...] = ("a", "b"), command: str | None = None) -> Recording:
    return read_recording(path, scenario(command=command), joints, file=FILE)


@pytest.mark.parametrize("form", FORMS)
def test_joints_of_one_stamp_are_one_sample(form: str, tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    """Received one after the other, with those of a joint that is not asked for in between."""
    messages = []
    for k in range(100):
        for i, name in enumerate(("gripper", "b", "a")):
            messages.append(joint(name, 0.01 * k, 10.0 * i + k, late=0.001 * i))
    recording = read(write_bag(tmp_path / ("run.bag" if form == "bag" else "run"), form, messages))
    count = np.arange(100.0)
    trace = Signals(recording.trace)
    np.testing.assert_array_equal(trace.position, np.column_stack([20.0 + count, 10.0 + count]))
    np.testing.assert_array_equal(trace.velocity, 2.0 * trace.position)
    np.testing.assert_allclose(trace.time, 0.01 * count, atol=1e-6)
    assert recording.absent == ()
    assert recording.notes == (
        "times are header stamps",
        "/joint_states: 100 messages name other joints and were passed over",
        "/joint_states: comes in 2 kinds of messages (100 of b; 100 of a), which are merged joint by joint",
    )


@pytest.mark.parametrize("form", FORMS)
def test_other_stamps_are_interpolated_and_never_across_a_gap(
    form: str, tmp_path: Path, write_bag: Callable[..., Path]
) -> None:
    """An arm at 100 Hz and a slower gripper, which is silent for a while in the middle."""
    messages = []
    for k in range(200):
        arm = {"stamp": EPOCH + 0.01 * k, "name": ["a", "b"], "position": [float(k), -float(k)]}
        messages.append(("/joint_states", EPOCH + 0.01 * k, STATE, arm))
    messages += [joint("c", t, 5.0 * t) for t in 0.003 + 0.025 * np.arange(79) if not 0.9 < t < 1.2]
    messages.sort(key=lambda message: message[1])
    path = write_bag(tmp_path / ("run.bag" if form == "bag" else "run"), form, messages)
    recording = read(path, ("a", "b", "c"))
    trace = Signals(recording.trace)
    own = 0.01 * np.arange(200)
    there = (own > 0.003) & (own < 1.953) & ~((own > 0.878) & (own < 1.203))
    np.testing.assert_allclose(trace.time, own[there], atol=1e-6)
    np.testing.assert_array_equal(trace.position[:, 0], np.arange(200.0)[there])
    np.testing.assert_allclose(trace.position[:, 2], 5.0 * own[there], atol=1e-5)
    told = " ".join(recording.notes)
    assert f"{path}: /joint_states is taken at the stamps of a; in between, c is interpolated" in told
    assert f"{(~there).sum()} of 200 samples are left out, as they are without the position of c" in told


def test_every_publisher_has_an_order_and_stamps_of_its_own(tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    """What comes late of one is no disorder of the other; a stamp that one repeats is dropped once."""
    stamps = [0.0, 0.01, 0.03, 0.02, 0.02, 0.04, 0.05, 0.06, 0.07, 0.08]
    messages = [joint("a", 0.01 * k, float(k)) for k in range(10)]
    messages += [
        ("/joint_states", EPOCH + 0.01 * k + 0.005, *joint("b", s, float(k))[2:]) for k, s in enumerate(stamps)
    ]
    messages.sort(key=lambda message: message[1])
    recording = read(write_bag(tmp_path / "run", "mcap", messages))
    np.testing.assert_allclose(recording.trace.time, 0.01 * np.arange(9), atol=1e-6)
    np.testing.assert_array_equal(Signals(recording.trace).position[:, 1], [0, 1, 4, 2, 5, 6, 7, 8, 9])
    (repeated,) = [lack for lack in recording.absent if lack.kind == "repeats"]
    assert repeated.text == (
        "/joint_states (b): 1 messages came out of order and were sorted; 1 messages repeat the stamp of another and "
        "were dropped, of 10"
    )


def test_many_publishers_with_one_stamp_have_a_header_clock(tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    names = ("a", "b", "c", "d")
    messages = [joint(n, 0.01 * k, float(k), late=0.001 * i) for k in range(50) for i, n in enumerate(names)]
    recording = read(write_bag(tmp_path / "run", "db3", messages), names)
    assert recording.notes[0] == "times are header stamps"
    assert len(recording.trace.time) == 50


def test_commands_of_one_stamp_for_several_joints_all_count(tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    """And a joint keeps its last one where only others are commanded."""
    messages = []
    for k in range(40):
        state = {"stamp": EPOCH + 0.01 * k, "name": ["a", "b"], "position": [0.0, 0.0]}
        messages.append(("/joint_states", EPOCH + 0.01 * k, STATE, state))
        messages.append(joint("a", 0.01 * k, float(k), "/joint_commands"))
        if k % 2 == 0:
            messages.append(joint("b", 0.01 * k, 100.0 + k, "/joint_commands", late=0.0001))
    recording = read(write_bag(tmp_path / "run", "mcap", messages), command="/joint_commands")
    count = np.arange(40.0)
    np.testing.assert_array_equal(Signals(recording.trace).command, np.column_stack([count, 100.0 + count - count % 2]))
    assert recording.absent == ()


def test_a_joint_that_few_messages_leave_out_costs_no_sample(tmp_path: Path, write_bag: Callable[..., Path]) -> None:
    messages = []
    for k in range(100):
        names = ["a"] if k in (20, 60) else ["b", "a"]
        state = {"stamp": EPOCH + 0.01 * k, "name": names, "position": [float(k)] * len(names)}
        messages.append(("/joint_states", EPOCH + 0.01 * k, STATE, state))
    recording = read(write_bag(tmp_path / "run", "mcap", messages))
    np.testing.assert_allclose(Signals(recording.trace).position, np.tile(np.arange(100.0)[:, None], (1, 2)), atol=1e-4)
