"""What the recorded supply voltage and friction are worth on the XL330 pendulum, engine by engine.

    REALITYGAP_DATA=... python tests/bench_xl330.py [--write results/reference/xl330_supply.csv]

Mean absolute position error [rad] of two recordings: the supply as recorded (it sags and rises) or constant at its
mean, the published friction (model M1) or none.
"""

import argparse
from pathlib import Path

import numpy as np
import pandas as pd
import realitygap_engines as engines
from realitygap.compare.comparison import compare, motions
from realitygap.scenario.file import load_scenario
from realitygap.simulate.experiment import experiments

SCENARIO = Path(__file__).parents[1] / "scenarios" / "xl330_pendulum" / "scenario.yaml"
RECORDINGS = ("lift_and_drop_kp400", "sin_sin_kp400")
NONE = {"servos.servo.friction": {"coulomb": 0.0, "viscous": 0.0}}


def main() -> None:
    """Print the table, and write it where asked."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--write", type=Path)
    options = parser.parse_args()
    file = load_scenario(SCENARIO)
    chosen = [m for m in motions(experiments(file)) if m.name in RECORDINGS]
    volts = float(
        np.mean([e.recording.supply.mean() for m in chosen for e in m.experiments if e.recording is not None])
    )
    steady = {"servos.servo.supply": round(volts, 3)}
    rows = []
    for supply, change in (("recorded", {}), (f"constant {volts:.2f} V", steady)):
        for friction, more in (("M1", {}), ("none", NONE)):
            changed = file.override(change | more)
            for motion in motions(experiments(changed)):
                if motion.name not in RECORDINGS:
                    continue
                for engine in engines.available():
                    found = compare(motion, engine, floors=False).rows
                    error = [np.deg2rad(r.mean_abs) for r in found if r.signal == "position"]
                    rows.append((motion.name, supply, friction, engine, float(np.mean(error))))
    frame = pd.DataFrame(rows, columns=["recording", "supply", "friction", "engine", "error"])
    wide = frame.pivot_table(index=["recording", "supply", "friction"], columns="engine", values="error").round(5)
    print(wide.to_string())
    if options.write:
        wide.to_csv(options.write, lineterminator="\n")


if __name__ == "__main__":
    main()
