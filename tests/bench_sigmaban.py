"""The whole-body figures: mean absolute position error [rad] over 18 joints in the published windows, engine by engine.

    REALITYGAP_DATA=... python tests/bench_sigmaban.py [SCENARIO] [--only kick_p32,...] [--write FILE]

The published figures are those of the authors' MuJoCo simulation with the same servo parameters.
"""

import argparse
import os
from pathlib import Path

import numpy as np
import pandas as pd
import realitygap_engines as engines
from realitygap.compare.comparison import compare, motions
from realitygap.compare.row import EXCLUDED
from realitygap.compare.table import table
from realitygap.scenario.file import load_scenario
from realitygap.simulate.experiment import experiments

ROOT = Path(__file__).parents[1]


def errors(scenario: Path, names: list[str], only: set[str]) -> pd.DataFrame:
    """One row per recording, one column per engine [rad]."""
    file = load_scenario(scenario)
    rows = []
    for motion in motions(experiments(file)):
        if only and motion.name not in only:
            continue
        for engine in names:
            rows += compare(motion, engine, floors=False).rows
    gaps = table(rows)
    kept = gaps[(gaps["signal"] == "position") & (gaps["note"] != EXCLUDED)]
    mean = kept.groupby(["recording", "engine"])["mean_abs"].mean().unstack()
    return mean * np.pi / 180


def main() -> None:
    """Print, and write where asked."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenario", nargs="?", type=Path, default=ROOT / "scenarios" / "sigmaban" / "scenario.yaml")
    parser.add_argument("--engine", action="append", default=[])
    parser.add_argument("--model", default="M1", help="friction model of the published figures, or best")
    parser.add_argument("--only", default="")
    parser.add_argument("--write", type=Path)
    options = parser.parse_args()
    names = options.engine or engines.available()
    found = errors(options.scenario, names, set(filter(None, options.only.split(","))))
    published = pd.read_csv(Path(os.environ["REALITYGAP_DATA"]) / "sigmaban" / "published_mae.csv")
    if options.model != "best":
        published = published[published["friction_model"] == options.model]
    best = published.groupby("recording")["mae_rad"].min()
    found.insert(0, f"published {options.model}", best.reindex(found.index))
    print(found.round(5).to_string())
    if options.write:
        found.round(5).to_csv(options.write, lineterminator="\n")


if __name__ == "__main__":
    main()
