"""`realitygap run` from the scenario file to the files it leaves, in one engine."""

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
import xml.etree.ElementTree as ET
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import yaml
from numpy.testing import assert_allclose
from realitygap.cli.main import main
from realitygap.cli.results import make, summary
from realitygap.compare.row import COLUMNS
from realitygap.compare.table import read_gaps
from realitygap.compare.traces import read_traces
from realitygap.files.errors import InputError
from realitygap.files.progress import Progress
from realitygap.matrix.collect import Collected
from realitygap.matrix.junit import write_junit
from realitygap.matrix.matrix import ONCE
from realitygap.matrix.matrix_file import matrix_of
from realitygap.scenario.engine_names import engine_names
from realitygap.scenario.file import load_scenario
from realitygap.simulate.experiment import experiments, simulate
from realitygap.trace.parquet import read_parquet
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore
from signals import Signals, there

DEMO = Path(__file__).parents[2] / "scenarios" / "demo" / "scenario.yaml"
ENGINE = "mujoco"
QUIET = Progress(quiet=True)


@dataclass(frozen=True)
class Run:
    """A run and the folder that it left."""

    folder: Path
    made: Collected

    def excess(self, **budget: float) -> list[str]:
        """The sentences on what exceeds a budget."""
        return [x for found in self.made.excess(budget).values() for x in found] + self.made.not_judged(budget)


def run(path: Path, out: Path, engine: str = ENGINE) -> Run:
    return Run(out, make(matrix_of(load_scenario(path), [engine]), out, ONCE, QUIET))


@pytest.fixture(scope="module")
def demo(tmp_path_factory: pytest.TempPathFactory) -> Run:
    return run(DEMO, tmp_path_factory.mktemp("demo") / "out")


def variant(folder: Path, **changes: object) -> Path:
    """The demo with one recording and with keys changed."""
    for name in ("arm.urdf", "chirp_1.mcap"):
        shutil.copy(DEMO.with_name(name), folder)
    raw = yaml.safe_load(DEMO.read_text())
    raw["recordings"]["runs"] = [{"path": "chirp_1.mcap", "use": "held_out"}]
    path = folder / "scenario.yaml"
    path.write_text(yaml.safe_dump(raw | changes))
    return path


def test_every_file_is_there(demo: Run) -> None:
    names = {p.relative_to(demo.folder).as_posix() for p in demo.folder.rglob("*") if p.is_file()}
    assert {"gaps.csv", "timings.csv", "manifest.json", "report.html"} <= names
    manifest = json.loads((demo.folder / "manifest.json").read_text())
    assert manifest["virtual"] is True
    traces = sorted(n.removesuffix(".mcap") for n in names if n.endswith(".mcap"))
    assert len(traces) == 5
    assert sorted(n.removesuffix(".parquet") for n in names if n.endswith(".parquet")) == traces
    assert sorted(manifest["traces"].values()) == [f"{n}.mcap" for n in traces]
    assert [n for n in names if n.startswith("figures/")]
    assert not [n for n in names if n.startswith((".", "cells"))]


def test_rows_are_complete(demo: Run) -> None:
    """Every motion × joint × signal once; the two repetitions are one motion with a noise floor of their own."""
    frame = read_gaps(demo.folder / "gaps.csv")
    assert frame.columns.tolist() == COLUMNS
    motions = {"chirp_1", "sines_1 ×2", "sines_2", "steps_1", "triangle_1"}
    found = set(zip(frame["recording"], frame["joint"], frame["signal"], strict=True))
    assert found == {
        (m, j, s) for m in motions for j in ("shoulder", "elbow") for s in ("position", "velocity", "effort")
    }
    assert len(frame) == len(found)
    assert (frame["outcome"] == "ok").all()
    assert (
        np.isfinite(frame[["mean_abs", "median_abs", "p95_abs", "max_abs", "noise_floor", "numerical_floor"]])
        .all()
        .all()
    )
    assert (frame["median_abs"] <= frame["p95_abs"]).all()
    assert (frame["p95_abs"] <= frame["max_abs"]).all()
    assert set(frame.loc[frame["recording"] == "sines_2", "use"]) == {"held_out"}
    assert set(frame.loc[frame["recording"] == "sines_2", "robot_revision"]) == {"arm_loaded"}


def test_gaps_are_those_of_a_good_model_with_one_thing_missing(demo: Run) -> None:
    """Large beside the floors, small beside the motion of some 60°."""
    position = demo.made.gaps[demo.made.gaps["signal"] == "position"]
    assert (position["mean_abs"] < 1.0).all()
    elbow = position[position["joint"] == "elbow"]
    assert (elbow["mean_abs"] > 3 * elbow[["noise_floor", "numerical_floor"]].max(axis=1)).any()
    assert position["mean_abs"].mean() > 3 * position["noise_floor"].mean()


def test_timings_say_how_fast(demo: Run) -> None:
    timings = pd.read_csv(demo.folder / "timings.csv")
    assert len(timings) == 5
    seconds = timings["steps"] / timings["step_rate"]
    assert_allclose(timings["real_time_factor"], seconds / timings["wall_seconds"], rtol=1e-4)


def test_traces_open_in_other_tools(demo: Run) -> None:
    """Standard messages, measured and simulated side by side on one clock, the measured ones as they were recorded."""
    (path,) = (demo.folder / "traces").glob("*chirp_1*.mcap")
    (case,) = experiments(load_scenario(DEMO), only=["chirp_1"])
    assert case.recording is not None
    recorded = case.recording.trace
    read: dict[str, list[tuple[float, list[str], np.ndarray, np.ndarray]]] = {}
    with AnyReader([path], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as bag:
        assert {c.msgtype for c in bag.connections} == {"sensor_msgs/msg/JointState"}
        for connection, stamp, raw in bag.messages():
            m: Any = bag.deserialize(raw, connection.msgtype)
            assert m.header.stamp.sec + 1e-9 * m.header.stamp.nanosec == pytest.approx(1e-9 * stamp, abs=1e-9)
            read.setdefault(connection.topic, []).append((1e-9 * stamp, m.name, m.position, m.effort))
    assert set(read) == {"/simulated/joint_states", "/measured/joint_states"}
    measured, simulated = read["/measured/joint_states"], read["/simulated/joint_states"]
    assert measured[0][1] == simulated[0][1] == ["shoulder", "elbow"]
    assert_allclose(np.diff([m[0] for m in measured]).mean(), np.diff(recorded.time).mean(), rtol=1e-6)
    assert_allclose([m[2] for m in measured], there(recorded.position))
    assert_allclose([m[3] for m in measured], there(recorded.effort))
    assert measured[-1][0] == pytest.approx(simulated[-1][0], abs=0.02)


def test_traces_are_kept_whole(demo: Run) -> None:
    """Every step with command and effort, to the last bit; of a motion recorded twice, both simulations besides."""
    (path,) = (demo.folder / "traces").glob("*chirp_1*.parquet")
    (case,) = experiments(load_scenario(DEMO), only=["chirp_1"])
    again, kept = simulate(case, ENGINE).trace, read_parquet(path)
    assert set(kept) == {"simulated", "measured"}
    for name in ("time", "position", "velocity", "effort", "command"):
        np.testing.assert_array_equal(getattr(kept["simulated"], name), getattr(again, name))
    assert case.recording is not None
    np.testing.assert_array_equal(kept["measured"].time, case.recording.trace.time)
    (path,) = (demo.folder / "traces").glob("*sines_1*.parquet")
    several = read_parquet(path)
    assert set(several) == {"simulated", "measured", "simulated sines_1_rep1", "simulated sines_1_rep2"}
    assert len(several["simulated"].time) == len(several["measured"].time)
    assert len(several["simulated sines_1_rep2"].time) > 5 * len(several["simulated"].time)


def test_the_same_scenario_gives_the_same_bytes(demo: Run, tmp_path: Path) -> None:
    again = run(variant(tmp_path), tmp_path / "out")

    def lines(result: Run) -> list[str]:
        return [x for x in (result.folder / "gaps.csv").read_text().splitlines() if ",chirp_1," in x]

    assert len(lines(again)) == 6
    assert lines(again) == lines(demo)
    (old,), (new,) = ((r.folder / "traces").glob("*chirp_1*.mcap") for r in (demo, again))
    assert old.name == new.name
    assert old.read_bytes() == new.read_bytes()


def test_a_finished_run_holds_its_own_files_and_what_a_person_put_there(tmp_path: Path) -> None:
    out = tmp_path / "out"
    path = variant(tmp_path)
    run(path, out)
    (out / "notes.txt").write_text("mine")
    (out / "figures" / "photo.jpg").write_text("mine")
    (out / "figures" / "mine.svg").write_text("mine")
    (out / "traces" / "mine.mcap").write_text("mine")
    (out / ".unfinished-of-a-killed-run").mkdir()
    os.utime(out / ".unfinished-of-a-killed-run", (0, 0))
    path.write_text(path.read_text().replace("name: demo", "name: other"))
    (tmp_path / "chirp_1.mcap").rename(tmp_path / "chirp_2.mcap")
    path.write_text(path.read_text().replace("chirp_1", "chirp_2"))
    run(path, out)
    files = {p.relative_to(out).as_posix() for p in out.rglob("*") if p.is_file()}
    assert {"notes.txt", "figures/photo.jpg", "figures/mine.svg", "traces/mine.mcap"} <= files
    assert not list(out.glob(".*"))
    assert not [f for f in files if "chirp_1" in f or f.startswith(".")]
    assert [f for f in files if "chirp_2" in f]


@pytest.mark.parametrize(
    ("number", "status", "word"), [(signal.SIGINT, 130, "interrupted"), (signal.SIGTERM, 143, "ended by SIGTERM")]
)
def test_an_interrupted_run_leaves_everything_as_it_was(
    number: signal.Signals, status: int, word: str, demo: Run, tmp_path: Path
) -> None:
    def content(folder: Path) -> dict[str, bytes]:
        return {p.relative_to(folder).as_posix(): p.read_bytes() for p in folder.rglob("*") if p.is_file()}

    old, new = tmp_path / "old", tmp_path / "deep" / "new"
    shutil.copytree(demo.folder, old)
    before = content(old)
    for out in (old, new):
        command = [sys.executable, "-m", "realitygap.cli.main", "run", str(DEMO), "-e", ENGINE, "-o", str(out)]
        process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
        while not list(out.glob(".unfinished-*/cells-*/*.zip")):
            assert process.poll() is None
            time.sleep(0.01)
        process.send_signal(number)
        _, said = process.communicate(timeout=60)
        assert process.returncode == status
        assert said.splitlines()[-1] == f"realitygap: {word}; nothing was written"
        assert "Traceback" not in said
    assert content(old) == before
    assert not (tmp_path / "deep").exists()


def test_what_a_terminal_shows(demo: Run) -> None:
    shown = summary(demo.made)
    assert len(shown) == 3
    assert all(ENGINE in line and "noise floor" in line for line in shown)


def test_a_blow_up_is_an_outcome(tmp_path: Path) -> None:
    """A gain no step of 20 ms can hold: rows that say when and where, infinite gaps, no number."""
    stiff = [{"joints": "*", "kind": "cascade", "gain": 1e6, "kv": 1e3, "kp": 1e3}]
    text = (tmp_path / "arm.urdf", variant(tmp_path, servos=stiff, physics={"step_rate": 50}))[0]
    text.write_text(text.read_text().replace('effort="', 'effort="1e12" was="'))
    result = run(tmp_path / "scenario.yaml", tmp_path / "out")
    frame = read_gaps(tmp_path / "out" / "gaps.csv")
    assert set(frame["outcome"]) == {"diverged"}
    assert len(frame) == 6
    assert np.isinf(frame[["mean_abs", "median_abs", "p95_abs", "max_abs"]]).all().all()
    assert frame["note"].str.match(r"diverged at \d+\.\d+ s at (shoulder|elbow|base): ").all()
    assert "diverged" in summary(result.made)[0]
    assert "diverged" in (tmp_path / "out" / "report.html").read_text()
    assert not list((tmp_path / "out").glob("traces/*"))
    (sentence,) = result.excess(position=1.0)
    assert "diverged" in sentence
    write_junit(tmp_path / "junit.xml", "demo", result.made.cells, result.made.excess({"position": 1.0}))
    suite = ET.parse(tmp_path / "junit.xml").getroot()
    assert (suite.get("tests"), suite.get("errors"), suite.get("failures")) == ("1", "1", "0")


def test_what_an_engine_cannot_express_is_an_outcome(tmp_path: Path) -> None:
    path = variant(tmp_path, ground="flat")
    urdf = (tmp_path / "arm.urdf").read_text()
    elbow = '<child link="forearm"/>'
    (tmp_path / "arm.urdf").write_text(urdf.replace(elbow, f'{elbow}<mimic joint="shoulder"/>'))
    result = run(path, tmp_path / "out", "mujoco")
    frame = read_gaps(tmp_path / "out" / "gaps.csv")
    assert len(frame) == 6
    assert set(frame["outcome"]) == {"unsupported"}
    assert np.isinf(frame["mean_abs"]).all()
    assert frame["note"].str.startswith("mimic joints on the ground are not supported").all()
    (sentence,) = result.excess(position=1.0)
    assert "position was not judged, as no engine of the run can simulate the scenario" in sentence


def test_without_recordings_there_are_traces_and_no_gaps(tmp_path: Path) -> None:
    (tmp_path / "move.json").write_text('{"keyframes": [{"goals": {"elbow": 20}, "duration": 0.5, "pause": 0.2}]}')
    path = variant(tmp_path, motion={"keyframes": "move.json"}, recordings=None)
    result = run(path, tmp_path / "out")
    assert result.made.gaps.empty
    assert summary(result.made) == ["nothing was measured: no gap, traces only"]
    (path,) = (tmp_path / "out" / "traces").glob("*.parquet")
    trace = read_traces(path).simulated
    assert trace.position is not None
    assert trace.time[-1] == pytest.approx(0.7 + 1.0, abs=2e-3)
    assert np.rad2deg(trace.position[-1]) == pytest.approx([0.0, 20.0], abs=1.5)


@pytest.mark.parametrize(
    ("stated", "options", "status", "said"),
    [
        (None, [], 0, []),
        ({"position": 0.01}, [], 1, ["over budget: mujoco, chirp_1: position"]),
        ({"position": 0.01}, ["--max-gap", "5"], 0, []),
        ({"position": 5.0}, ["--max-gap", "effort=0.001"], 1, ["over budget: mujoco, chirp_1: effort"]),
    ],
)
def test_budgets_decide_the_exit_status(
    stated: object, options: list[str], status: int, said: list[str], tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    path = variant(tmp_path, budget=stated)
    command = ["run", str(path), "-e", ENGINE, "-o", str(tmp_path / "out"), "--junit", str(tmp_path / "junit.xml")]
    with pytest.raises(SystemExit) as end:
        main([*command, *options])
    assert end.value.code == status
    out, err = capfd.readouterr()
    assert [
        x[: len(s)] for x, s in zip([x for x in out.splitlines() if x.startswith("over")], said, strict=True)
    ] == said
    assert out.splitlines()[-1] == f"report: {tmp_path / 'out' / 'report.html'}"
    assert all(line.startswith("simulating ") for line in err.splitlines()), "a library speaks"
    suite = ET.parse(tmp_path / "junit.xml").getroot()
    assert (suite.get("tests"), suite.get("failures")) == ("1", str(status))


def test_a_budget_that_judged_nothing_is_not_kept(tmp_path: Path) -> None:
    raw = yaml.safe_load(DEMO.read_text())["recordings"] | {"exclude": ["*"]}
    raw["runs"] = [{"path": "chirp_1.mcap"}]
    result = run(variant(tmp_path, recordings=raw), tmp_path / "out")
    (sentence,) = result.excess(position=0.0001)
    assert sentence.startswith("over budget: no position of a moving joint was measured, or all are left out")


def test_engines_can_be_chosen() -> None:
    assert engine_names(["mujoco", "mujoco"]) == ["mujoco"]
    assert "mujoco" in engine_names([])
    with pytest.raises(InputError, match="found gazebo; expected one of dart, drake"):
        engine_names(["gazebo"])


def test_a_limit_that_the_recording_passes_does_not_stop_the_simulation(tmp_path: Path) -> None:
    path = variant(tmp_path)
    arm = tmp_path / "arm.urdf"
    before = experiments(load_scenario(path))[0]
    assert before.notes == ()
    reached = Signals(there(before.recording).trace).position[:, 1]
    tight = f'lower="-0.2" upper="{reached.max() + 1:.3f}"'
    assert reached.min() < -0.25
    text, n = re.subn(
        r'(<joint name="elbow".*?)lower="[^"]*" upper="[^"]*"', rf"\g<1>{tight}", arm.read_text(), flags=re.S
    )
    assert n == 1
    arm.write_text(text)
    after = experiments(load_scenario(path))[0]
    assert len(after.notes) == 1
    assert after.notes[0].startswith("elbow was measured past the URDF's lower limit of -11.46°: the stop is elsewhere")
    reaches, reached_before = (Signals(simulate(e, ENGINE).trace).position for e in (after, before))
    assert_allclose(reaches, reached_before)
