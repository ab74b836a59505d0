"""What `run` says on the terminal: floors, lost readings, and whose results it replaces (the demo, synthetic)."""

import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml
from realitygap.check.mistake import KINDS
from realitygap.cli.main import main
from realitygap.cli.results import make, summary
from realitygap.files.progress import Progress
from realitygap.matrix.matrix import ONCE, results
from realitygap.matrix.matrix_file import matrix_of
from realitygap.scenario.file import load_scenario

DEMO = Path(__file__).parents[2] / "scenarios" / "demo"
ENGINE = "mujoco"


def variant(folder: Path, **changes: object) -> Path:
    """The demo with one of its recordings, and with keys changed."""
    content = yaml.safe_load((DEMO / "scenario.yaml").read_text())
    run = content["recordings"]["runs"][0]
    for file in ("arm.urdf", "arm_heavy.urdf", run["path"]):
        shutil.copy(DEMO / file, folder / file)
    content["recordings"]["runs"] = [run]
    (folder / "scenario.yaml").write_text(yaml.safe_dump(content | changes))
    return folder / "scenario.yaml"


def test_a_terminal_says_where_the_floors_show_no_difference(tmp_path: Path) -> None:
    """As the page does: from the recording, and from the engine that is closest."""
    made = make(matrix_of(load_scenario(variant(tmp_path)), [ENGINE]), tmp_path / "out", ONCE, Progress(quiet=True))
    one = made.gaps
    other = one.assign(engine="dart", mean_abs=1.05 * one["mean_abs"])
    for floor, first, second in (
        (0.0, False, ""),
        (0.1, False, f"; no difference seen to {ENGINE})"),
        (9.0, True, "; no difference seen from the recording)"),
    ):
        both = pd.concat([one, other]).assign(noise_floor=0.0)
        both["numerical_floor"] = floor * both["mean_abs"]
        told = summary(replace(made, gaps=both))
        for line in told[::2]:  # of every signal, dart's before MuJoCo's
            assert line.endswith(second or ")")
            assert ("no difference seen" in line) == bool(second)
        assert all(("no difference seen from the recording" in line) == first for line in told[1::2])


def test_readings_that_are_lost_are_told_where_they_are_a_part(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Before the long work begins, in one line of each kind; of single ones only in how many recordings they are."""
    time = np.arange(100) * 0.01
    frame = pd.DataFrame({"time": time, "command": 0.1 * time, "position": 0.1 * time, "velocity": 0.1})
    frame = frame.rename(columns={c: f"{c}_elbow" for c in frame if c != "time"})
    frame = frame.assign(command_shoulder=0.0, position_shoulder=0.0, velocity_shoulder=0.0)
    lossy, single = frame.copy(), frame.copy()
    lossy.loc[20:39, "position_elbow"] = np.nan
    single.loc[50, "position_elbow"] = np.nan
    for name, table in (("a", lossy[:-1]), ("b", lossy.drop(range(60, 80))), ("c", single)):
        table.to_csv(tmp_path / f"{name}.csv", index=False)
    runs = [{"path": f"{name}.csv"} for name in "abc"]
    path = variant(tmp_path, motion={"recorded": "command"}, recordings={"runs": runs}, accept=[*KINDS])
    with results(matrix_of(load_scenario(path), [ENGINE]), tmp_path / "out", ONCE, Progress()):
        pass
    told = [line for line in capsys.readouterr().err.splitlines() if "simulating" not in line]
    assert told == [
        "b: 20 of 80 samples are left out, as they are without the position of elbow (20) (and in 1 other recording)",
        "b: no samples from 0.590 to 0.800 s, which come every 10 ms otherwise",
        "recordings in which readings are absent: 3 (listed in manifest.json)",
    ]


def test_what_was_done_about_a_clock_or_an_encoder_is_told(
    tmp_path: Path, write_bag: Callable[..., Path], capsys: pytest.CaptureFixture[str]
) -> None:
    """By `run` and by `check`, as the page does; no reading is absent for it."""
    messages = []
    for k in range(200):
        q = 3.0 + 0.5 * np.sin(0.05 * k)
        for topic, angle in (("/joint_states", np.arctan2(np.sin(q), np.cos(q))), ("/commands", q)):
            fields = {"name": ["shoulder", "elbow"], "position": [0.0, angle]}
            messages.append((topic, 1.7e9 + 0.01 * k, "sensor_msgs/msg/JointState", fields))
    write_bag(tmp_path / "run", "mcap", messages)
    recordings = {"state": "/joint_states", "effort": "none", "runs": [{"path": "run"}]}
    path = variant(tmp_path, motion={"recorded": "/commands"}, recordings=recordings, accept=[*KINDS])
    with results(matrix_of(load_scenario(path), [ENGINE]), tmp_path / "out", ONCE, Progress()):
        pass
    told = [
        "run: times are those of reception: /commands has messages without a header stamp",
        "run: the position of elbow jumps by a whole turn 4 times (at 0.060, 0.580, 1.320, ... s), as no motion does: "
        "its angle begins again there, and the turns are counted",
    ]
    assert [line for line in capsys.readouterr().err.splitlines() if "simulat" not in line] == told
    with pytest.raises(SystemExit, match="0"):
        main(["check", str(path)])
    said = [line for line in capsys.readouterr().out.splitlines() if line.startswith("note: ")]
    assert said[:2] == [f"note: {line}" for line in told]


def test_a_run_says_whose_results_it_replaces(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out, told = tmp_path / "out", []
    for number, name in enumerate(("kick", "kick", "jump")):
        folder = tmp_path / str(number)
        folder.mkdir()
        path = variant(folder, name=name)
        with pytest.raises(SystemExit, match="0"):
            main(["run", str(path), "--engine", "mujoco", "--out", str(out)])
        told.append([line for line in capsys.readouterr().out.splitlines() if "are replaced" in line])
    assert told == [[], [], [f"the results of kick, which were in {out}, are replaced; --out takes another folder"]]
