"""Errors of the recordings that a scenario holds out, each repetition by itself: what published errors are told in.

    REALITYGAP_DATA=... python tests/bench_judged.py SCENARIO [--engine mujoco] [--signal position]

SCENARIO is a committed one, or the `revised/` of a diagnosis. A diagnosis judges the mean of repetitions. Pooled over
all samples of all recordings: root mean square and mean absolute error; and the means of both over recordings, which
some publish.
"""

import argparse
from pathlib import Path

import numpy as np
import pandas as pd
from realitygap.scenario.file import ScenarioFile, load_scenario
from realitygap.simulate.experiment import experiments, simulate


def errors(file: ScenarioFile, engine: str, signal: str) -> pd.DataFrame:
    """A row per held-out recording: samples, root mean square and mean absolute error over all joints, in SI units."""
    rows = []
    for experiment in experiments(file):
        if experiment.use != "held_out" or experiment.recording is None:
            continue
        measured = experiment.recording.trace.between(*experiment.window)
        simulated = simulate(experiment, engine).trace.at(measured.time)
        error = getattr(simulated, signal) - getattr(measured, signal)
        rows.append((experiment.name, error.size, float(np.sqrt(np.mean(error**2))), float(np.mean(np.abs(error)))))
    return pd.DataFrame(rows, columns=["recording", "samples", "rms", "mean_abs"])


def main() -> None:
    """Print a row per recording and the totals."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenario", type=Path)
    parser.add_argument("--engine", default="mujoco")
    parser.add_argument("--signal", default="position", choices=["position", "velocity", "effort"])
    options = parser.parse_args()
    frame = errors(load_scenario(options.scenario), options.engine, options.signal)
    print(frame.round(5).to_string(index=False))
    share = frame["samples"] / frame["samples"].sum()
    print(f"{len(frame)} recordings: rms {np.sqrt((share * frame['rms'] ** 2).sum()):.4f}, ", end="")
    print(f"mean absolute {(share * frame['mean_abs']).sum():.4f}; ", end="")
    print(f"means over recordings {frame['rms'].mean():.4f} and {frame['mean_abs'].mean():.4f}")


if __name__ == "__main__":
    main()
