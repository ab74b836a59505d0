"""The public protocol of the SO-101 recordings (newton-calibration-mvp1): its score for any scenario, in any engine.

    REALITYGAP_DATA=... python tests/bench_so101.py [SCENARIO] [--engine mujoco] [--windows] [--write FILE]

Four motions are judged, `frequency_sweep`, `friction_gravity`, `hold_under_gravity` and `backlash_detection`; beside
them stand five further episodes of the same data set, and all but those that the protocol trains on and judges. Of
every motion 12 s count, those with the most command motion. SCENARIO is the committed one, or the `revised/` of a
diagnosis: its robot, servos and effects are used, on every episode of its data set. `--windows` prints the windows.

Score of a motion, the less the better: 0.60 · position NRMSE + 0.15 · velocity NRMSE + 0.15 · phase lag [s] + 0.10 ·
position NRMSE while holding. Published: 1.915 before and 0.151 after a fit of 11 scalars.
"""

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import realitygap_engines as engines
from realitygap.recording import Recording, read_recording
from realitygap.recording.commands import held_at
from realitygap.recording.readers.lerobot_folder import open_folder
from realitygap.scenario.file import ScenarioFile, load_scenario
from realitygap.simulate.experiment import experiments, simulate
from realitygap.trace.trace import Array, Trace

ROOT = Path(__file__).parents[1]
TRAIN = ("step_response", "chirp_sweep", "static_holding", "gripper_cycles")
JUDGED = ("frequency_sweep", "friction_gravity", "hold_under_gravity", "backlash_detection")
FURTHER = ("random_waypoints", "pick_place", "single_joint_elbow", "oscillation_low_freq", "slow_precision")
LENGTH = 12.0  # s of every motion
GRID = 0.02  # s: on which is judged
COARSE = 0.1  # s: on which the command's motion is summed
LONGEST = 0.25  # s: the largest lag that is looked for
LEAST_RANGE = 0.05  # rad or rad/s: what an error is divided by at least
HOLDING = 0.3  # of the samples are the slowest
LEAD = 1.0  # s that are simulated before what is judged: a simulation starts at rest
WEIGHTS = {"position": 0.60, "velocity": 0.15, "lag": 0.15, "holding": 0.10}


def window(recording: Recording) -> tuple[float, float]:
    """The 12 s [s] in which the command moves most: the sum over joints of its absolute change on a 0.1 s grid."""
    grid = np.arange(0.0, recording.trace.time[-1], COARSE)
    moved = np.abs(np.diff(held_at(recording.command_time, recording.command, grid), axis=0)).sum(axis=1)
    sums = np.concatenate([[0.0], np.cumsum(moved)])
    steps = round(LENGTH / COARSE)
    if len(moved) <= steps:
        return 0.0, LENGTH
    start = round(float(grid[np.argmax(sums[steps:] - sums[:-steps])]), 3)
    return start, round(start + LENGTH, 3)


def score(simulated: Trace, measured: Trace, command: Array) -> dict[str, float]:
    """The terms of the score and their weighted sum. Both traces and the command are on the grid."""
    assert simulated.position is not None
    assert simulated.velocity is not None
    assert measured.position is not None
    assert measured.velocity is not None
    pace = np.linalg.norm(np.gradient(command, axis=0), axis=1)
    hold = pace <= np.quantile(pace, HOLDING)
    terms = {
        "position": _nrmse(simulated.position, measured.position, np.full(len(pace), True)),
        "velocity": _nrmse(simulated.velocity, measured.velocity, np.full(len(pace), True)),
        "lag": float(np.mean([_lag(a, b) for a, b in zip(simulated.position.T, measured.position.T, strict=True)])),
        "holding": _nrmse(simulated.position, measured.position, hold),
    }
    return {"score": sum(WEIGHTS[name] * value for name, value in terms.items()), **terms}


def _nrmse(simulated: Array, measured: Array, where: Array) -> float:
    """The mean over joints of the rms error by the range of the measurement."""
    error = np.sqrt(((simulated - measured)[where] ** 2).mean(axis=0))
    return float((error / np.maximum(np.ptp(measured, axis=0), LEAST_RANGE)).mean())


def _lag(a: Array, b: Array) -> float:
    """The absolute lag [s] of the largest cross-correlation of two signals without their means; 0 where one rests."""
    most = round(LONGEST / GRID)
    a, b = a - a.mean(), b - b.mean()
    lags = sorted(range(-most, most + 1), key=abs)  # of equally good ones the smallest
    found = [float(a[max(0, k) : len(a) + min(0, k)] @ b[max(0, -k) : len(b) + min(0, -k)]) for k in lags]
    return abs(lags[int(np.argmax(found))]) * GRID


def on_grid(recording: Recording, span: tuple[float, float]) -> tuple[Trace, Array]:
    """What was measured and commanded on the protocol's grid."""
    grid = span[0] + GRID * np.arange(round(LENGTH / GRID), dtype=np.float64)
    return recording.trace.at(grid), held_at(recording.command_time, recording.command, grid)


def delayed(recording: Recording, span: tuple[float, float], time: float) -> Trace:
    """The command as a motion, that much later: what a score is without any simulator."""
    measured, _ = on_grid(recording, span)
    position = held_at(recording.command_time, recording.command, np.maximum(measured.time - time, 0.0))
    return replace(measured, position=position, velocity=np.gradient(position, GRID, axis=0))


def whole_set(file: ScenarioFile) -> tuple[ScenarioFile, dict[str, tuple[float, float]], dict[str, Recording]]:
    """The scenario on every episode of its data set, the window of each and the recordings, by task."""
    assert file.scenario.recordings is not None
    first = file.scenario.recordings.runs[0]
    case = file.cases()[0]
    path = file.resolve(first.path, "recordings.runs[0].path")
    joints = experiments(file, only=(case.name,))[0].plant.model.joint_names
    runs, windows, recordings = [], {}, {}
    for episode in open_folder(path).episodes:
        name = episode.tasks[0]
        asked = file.override({"recordings.episode": episode.number, "recordings.part": None}).scenario
        recordings[name] = read_recording(path, asked, joints, file=file.path)
        windows[name] = start, end = window(recordings[name])
        # the lead is time that counts nowhere: with it, judging does not begin with a robot at rest
        part = [max(0.0, start - LEAD), end + GRID]
        runs.append({"path": first.path, "episode": name, "part": part, "with": first.overrides})
    raw = {**file.raw, "recordings": {**file.raw["recordings"], "runs": runs}}
    return ScenarioFile(file.path, type(file.scenario).model_validate(raw), raw), windows, recordings


def scores(file: ScenarioFile, names: list[str]) -> pd.DataFrame:
    """One row per motion and engine; the engine `command + 80 ms` is the command itself, delayed."""
    whole, windows, recordings = whole_set(file)
    rows = []
    for name, recording in recordings.items():
        measured, command = on_grid(recording, windows[name])
        found = {"command + 80 ms": delayed(recording, windows[name], 0.08)}
        (experiment,) = experiments(whole, only=(name,))
        for engine in names:
            found[engine] = simulate(experiment, engine).trace.at(measured.time)
        for engine, trace in found.items():
            rows.append({"motion": name, "engine": engine, **score(trace, measured, command)})
    return pd.DataFrame(rows)


def means(frame: pd.DataFrame) -> pd.DataFrame:
    """The mean score of each set of motions, by engine."""
    sets = {
        "judged (the protocol's four)": frame["motion"].isin(JUDGED),
        "further (five named)": frame["motion"].isin(FURTHER),
        "all but train and judged": ~frame["motion"].isin([*TRAIN, *JUDGED]),
        "train": frame["motion"].isin(TRAIN),
        "all": frame["motion"].notna(),
    }
    return pd.DataFrame({name: frame[chosen].groupby("engine")["score"].mean() for name, chosen in sets.items()}).T


def main() -> None:
    """Print, and write where asked."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenario", nargs="?", type=Path, default=ROOT / "scenarios" / "so101" / "scenario.yaml")
    parser.add_argument("--engine", action="append", default=[])
    parser.add_argument("--windows", action="store_true", help="print the windows of all episodes, and nothing else")
    parser.add_argument("--write", type=Path)
    options = parser.parse_args()
    file = load_scenario(options.scenario)
    if options.windows:
        for name, span in whole_set(file)[1].items():
            print(f"{name}: {list(span)}")
        return
    frame = scores(file, options.engine or engines.available())
    wide = frame.pivot_table(index="motion", columns="engine", values="score", sort=False)
    print(wide.round(4).to_string(), "\n")
    print(means(frame).round(4).to_string())
    if options.write:
        frame.round(5).to_csv(options.write, index=False, lineterminator="\n")


if __name__ == "__main__":
    main()
