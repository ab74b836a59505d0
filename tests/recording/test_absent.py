"""Readings that are absent: samples without a position are left out, all else stays; rows of two rates; a cut file."""

from pathlib import Path

import bags
import numpy as np
import pandas as pd
import pytest
from bags import FILE
from realitygap.recording import read_recording
from realitygap.recording.faults import faults
from realitygap.recording.recording import Recording
from signals import Signals, there

TIME = np.arange(200) * 0.01
JOINTS = ("a", "b")


def table() -> pd.DataFrame:
    swing = np.sin(3 * TIME)
    frame = pd.DataFrame({"time": TIME})
    for k, joint in enumerate(JOINTS):
        frame[f"command_{joint}"], frame[f"position_{joint}"] = k + swing, k + 0.9 * swing
        frame[f"velocity_{joint}"], frame[f"effort_{joint}"] = 2.7 * np.cos(3 * TIME), TIME
    return frame


def read(frame: pd.DataFrame, folder: Path, command: str | None = "command", effort: str = "motor") -> Recording:
    frame.to_csv(folder / "run.csv", index=False)
    return read_recording(folder / "run.csv", bags.scenario(None, command, effort=effort), JOINTS, file=FILE)


def test_rows_without_a_position_are_left_out_and_told(tmp_path: Path) -> None:
    frame, whole = table(), read(table(), tmp_path)
    frame.loc[[3, 4, 5, 90], "position_b"] = np.nan
    frame.loc[[90, 91], "position_a"] = np.nan
    recording = read(frame, tmp_path)
    kept = np.delete(np.arange(200), (3, 4, 5, 90, 91))
    for signal in ("time", "position", "velocity", "effort", "command"):
        ours, theirs = getattr(recording.trace, signal), getattr(whole.trace, signal)[kept]
        np.testing.assert_array_equal(ours, theirs, err_msg=signal)
    np.testing.assert_array_equal(recording.command, whole.command)
    assert "5 of 200 samples are left out, as they are without the position of a (2), b (4)" in recording.notes


@pytest.mark.parametrize("signal", ["velocity", "effort"])
def test_another_reading_that_is_absent_costs_no_sample(signal: str, tmp_path: Path) -> None:
    """One between two others lies on their line, several are unknown."""
    frame = table()
    frame.loc[[50, *range(100, 110)], f"{signal}_a"] = np.nan
    recording = read(frame, tmp_path)
    value = there(getattr(recording.trace, signal))
    assert len(recording.trace.time) == 200
    np.testing.assert_array_equal(np.flatnonzero(np.isnan(value).any(axis=1)), np.arange(100, 110))
    np.testing.assert_allclose(value[50, 0], (value[49, 0] + value[51, 0]) / 2, rtol=1e-12)
    assert any(f"is without the {signal} of a (11)" in note for note in recording.notes)


@pytest.mark.parametrize("signal", ["velocity", "effort"])
def test_a_signal_that_a_joint_does_not_have_is_unknown_there(signal: str, tmp_path: Path) -> None:
    recording = read(table().assign(**{f"{signal}_b": np.nan}), tmp_path)
    value = there(getattr(recording.trace, signal))
    assert np.isfinite(value[:, 0]).all()
    assert np.isnan(value[:, 1]).all()
    assert faults(recording) == []
    assert any(f"is without the {signal} of b (200)" in note for note in recording.notes)


@pytest.mark.parametrize(
    ("state", "command"),
    [
        (TIME, TIME + 0.005),  # one after the other
        (TIME, TIME[::2]),  # at half the rate, on the same clock
        (TIME[::3], TIME),
        (TIME, TIME),  # one below the other, row by row
    ],
)
@pytest.mark.parametrize("joined", [False, True])
def test_rows_merged_of_two_rates_are_two_streams(
    state: np.ndarray, command: np.ndarray, joined: bool, tmp_path: Path
) -> None:
    """As loggers write them, in one row where times are the same or in two."""
    measured = pd.DataFrame({"time": state, **{f"position_{j}": np.sin(state) for j in JOINTS}})
    asked = pd.DataFrame({"time": command, **{f"command_{j}": np.cos(command) for j in JOINTS}})
    if joined:
        frame = measured.merge(asked, on="time", how="outer").sort_values("time")
    else:
        frame = pd.concat([measured, asked]).sort_values("time", kind="stable")
    recording = read(frame, tmp_path, effort="none")
    np.testing.assert_allclose(recording.trace.time, state, atol=1e-12)
    np.testing.assert_allclose(Signals(recording.trace).position[:, 0], np.sin(state))
    sent = recording.command_time >= command[0]
    np.testing.assert_allclose(recording.command_time[sent], command, atol=1e-12)
    np.testing.assert_allclose(recording.command[sent], np.tile(np.cos(command)[:, None], 2))
    assert np.isfinite(Signals(recording.trace).command).all()


def test_a_servo_that_is_off_for_a_while_still_is(tmp_path: Path) -> None:
    frame = table()
    frame.loc[50:54, ["command_a", "command_b"]] = np.nan
    recording = read(frame, tmp_path)
    np.testing.assert_array_equal(np.flatnonzero(np.isnan(Signals(recording.trace).command[:, 0])), np.arange(50, 55))


@pytest.mark.parametrize("cut", [1, 12, 30, 60])
def test_a_line_that_is_cut_off_is_left_out(cut: int, tmp_path: Path) -> None:
    """A logger that was killed: the last number of such a line is another one."""
    whole = read(table(), tmp_path)
    path = tmp_path / "run.csv"
    text = path.read_text().rstrip("\n")
    start = text.rindex("\n") + 1
    path.write_text(text[: start + cut])
    recording = read_recording(path, bags.scenario(None, "command", effort="motor"), JOINTS, file=FILE)
    np.testing.assert_array_equal(Signals(recording.trace).position, Signals(whole.trace).position[:-1])
    np.testing.assert_array_equal(Signals(recording.trace).effort, Signals(whole.trace).effort[:-1])
    assert "the last line is cut off and was left out" in recording.notes


def test_a_last_line_without_an_end_is_a_line(tmp_path: Path) -> None:
    read(table(), tmp_path)
    path = tmp_path / "run.csv"
    path.write_text(path.read_text().rstrip("\n"))
    recording = read_recording(path, bags.scenario(None, "command"), JOINTS, file=FILE)
    assert len(recording.trace.time) == 200
