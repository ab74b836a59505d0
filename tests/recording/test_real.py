"""The readers, the alignment and the fault checks on recordings of real machines."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from bags import FILE, Run, scenario
from realitygap.recording import Recording, read_recording
from realitygap.recording.align import group_repetitions, noise_floor
from realitygap.recording.faults import faults
from realitygap_engines.model.urdf import read_urdf
from signals import Signals

ENCODER = 2 * np.pi / 4096
KICKS = ("kick_p16", "kick_p20", "kick_p24", "kick_p28", "kick_p32")


SIGMABAN = scenario("/joint_states", "/joint_commands", "floating", imu="/imu/data")


@pytest.fixture(scope="module")
def sigmaban(data_dir: Path) -> dict[str, Recording]:
    joints = read_urdf(data_dir / "sigmaban/robot.urdf", floating=True).joint_names
    paths = sorted(p.parent for p in (data_dir / "sigmaban").glob("*/metadata.yaml"))
    return {p.name: read_recording(p, SIGMABAN, joints, file=FILE) for p in paths}


def test_sigmaban_is_read_whole(sigmaban: dict[str, Recording]) -> None:
    assert set(KICKS) <= set(sigmaban)
    for name, recording in sigmaban.items():
        trace = Signals(recording.trace)
        assert len(trace.time) == (1500 if name.startswith("kick") else 1000)
        assert trace.time[0] == 0.0
        assert 1 / np.median(np.diff(trace.time)) == pytest.approx(100.0, rel=2e-3)
        assert trace.position.shape == trace.velocity.shape == trace.command.shape == (len(trace.time), 20)
        assert np.isfinite(trace.command).all()
        assert "header stamps" in recording.notes[0]


def test_sigmaban_moves_when_the_published_windows_begin(sigmaban: dict[str, Recording], data_dir: Path) -> None:
    windows = pd.read_csv(data_dir / "sigmaban/published_mae.csv").drop_duplicates("recording").set_index("recording")
    for name, recording in sigmaban.items():
        if name in windows.index:
            steps = np.abs(np.diff(recording.command, axis=0)).max(axis=1)
            begins = recording.command_time[1:][steps > 0.003][0]
            assert -0.005 < begins - windows.window_start_s[name] < 0.06


def test_every_kick_has_its_glitch_and_the_squats_have_none(sigmaban: dict[str, Recording]) -> None:
    for name, recording in sigmaban.items():
        found = {fault.kind: fault for fault in faults(recording)}
        assert ("command glitch" in found) == name.startswith("kick")
        if name.startswith("kick"):
            assert len(found["command glitch"].joints) == 8
        if not name.startswith("drop"):
            assert found["velocity"].numbers["scale"] == pytest.approx(0.91, abs=0.005)
            assert found["velocity"].numbers["time"] == pytest.approx(0.014, abs=0.004)


def test_the_one_garbled_reading_is_taken_out_and_no_other(sigmaban: dict[str, Recording]) -> None:
    garbled = {name: r.outliers for name, r in sigmaban.items() if name in KICKS or name.startswith("squat")}
    assert {name for name, found in garbled.items() if found} == {"kick_p16"}
    (outlier,) = garbled["kick_p16"]
    assert (outlier.joint, outlier.signal) == ("left_ankle_roll", "velocity")
    assert outlier.value == pytest.approx(-381.9, abs=0.1)
    assert np.abs(Signals(sigmaban["kick_p16"].trace).velocity).max() < 10.0


@pytest.mark.parametrize(("motion", "off"), [("lift_and_drop", True), ("sin_sin", False), ("up_and_down", False)])
@pytest.mark.parametrize("gain", [100, 400])
def test_xl330_lets_go_at_two_seconds(motion: str, off: float, gain: int, data_dir: Path) -> None:
    path = data_dir / f"xl330_pendulum/{motion}_kp{gain}"
    recording = read_recording(
        path, scenario("/joint_states", "/joint_commands", battery="/battery"), ["pendulum"], file=FILE
    )
    silent = recording.trace.time[np.isnan(Signals(recording.trace).command[:, 0])]
    if off:
        assert silent[0] == pytest.approx(2.0, abs=0.006)
        assert silent[-1] == recording.trace.time[-1]
    else:
        assert silent.size == 0
    assert 5.5 < recording.supply.min() < recording.supply.max() < 9.5


@pytest.mark.parametrize("load", [0, 2, 4, 6, 8])
def test_mx106_current_in_newton_metres(load: int, data_dir: Path) -> None:
    asked = scenario("/joint_states", "/joint_commands", effort={"topic": "/joint_currents", "factor": 1 / 0.48})
    trace = Signals(read_recording(data_dir / f"mx106_bench/sine_{load}w.bag", asked, ["R1"], file=FILE).trace)
    assert len(trace.time) == 6001
    goal = np.pi / 3 * np.sin(np.pi / 2 * trace.time)
    np.testing.assert_allclose(trace.command[:, 0], goal, atol=2e-3)
    # m·g·l of the arm with this load [N·m]: the current has to carry it
    carried = {0: 0.584, 2: 1.020, 4: 1.456, 6: 1.892, 8: 2.328}[load]
    slope = np.polyfit(np.sin(trace.position[:, 0]), trace.effort[:, 0], 1)[0]
    assert slope == pytest.approx(carried, rel=0.35)


def test_mx106_duty(data_dir: Path) -> None:
    asked = scenario("/joint_states", "/duty_commands", meaning="duty")
    recording = read_recording(data_dir / "mx106_bench/horizontal_pwm_10.bag", asked, ["R1"], file=FILE)
    assert recording.command_kind == "duty"
    assert 0.05 < np.abs(recording.command).max() <= 1.0
    assert recording.trace.velocity is None


def test_sts3215_repetitions_and_their_noise(data_dir: Path) -> None:
    paths = sorted((data_dir / "sts3215_pendulum").glob("*_m0.535_l0.10_kp16_rep*.csv"))
    runs = [Run(p.stem, read_recording(p, scenario(None, "command"), ["pendulum"], file=FILE)) for p in paths]
    groups = group_repetitions(runs)
    assert [len(g.indices) for g in groups] == [4] * 5
    for group in groups:
        assert np.abs(group.shifts).max() < 1e-3  # they were all started by their own clock
        traces = [runs[i].recording.trace for i in group.indices]
        clock = traces[0].time[:-2]
        floor = noise_floor([t.at(clock) for t in traces])["pendulum", "position"]
        assert 1e-3 < floor < 0.03
        assert noise_floor(traces[:1])["pendulum", "position"] == pytest.approx(ENCODER / 4, rel=0.01)
    off = runs[next(g.indices[0] for g in groups if g.name.startswith("lift_and_drop"))].recording
    assert off.trace.time[np.isnan(Signals(off.trace).command[:, 0])][0] == pytest.approx(2.0, abs=0.02)


def test_emps_force(data_dir: Path) -> None:
    asked = scenario(None, "command", columns={"effort": "force"}, effort="motor")
    trace = Signals(read_recording(data_dir / "emps/estimation.csv", asked, ["slide"], file=FILE).trace)
    assert len(trace.time) == 24841
    # the published law of the drive explains the recorded force
    speed = np.gradient(trace.position[:, 0], trace.time)
    law = 35.15 * 243.45 * (160.18 * (trace.command - trace.position)[:, 0] - speed)
    assert np.corrcoef(law, trace.effort[:, 0])[0, 1] > 0.99


def test_cube_tosses_fly_as_they_are_said_to(data_dir: Path) -> None:
    paths = sorted((data_dir / "cube_toss").glob("toss_*.csv"))
    assert len(paths) >= 100
    for path in paths[:20]:
        trace = Signals(read_recording(path, scenario(None, None, "free"), [], file=FILE).trace)
        flight = slice(1, 20)
        speed = np.gradient(trace.base_position, trace.time, axis=0)
        assert np.abs(speed - trace.base_linear)[flight].mean() < 0.1
        # ω in world axes from the orientations: twice the vector part of dq/dt · conj(q)
        q, dq = trace.base_quaternion, np.gradient(trace.base_quaternion, trace.time, axis=0)
        w, v = q[:, :1], q[:, 1:]
        spin = 2.0 * (w * dq[:, 1:] - dq[:, :1] * v - np.cross(dq[:, 1:], v))
        assert np.abs(spin - trace.base_angular)[flight].mean() < 0.1 * np.abs(trace.base_angular).max()
