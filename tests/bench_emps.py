"""The relative force error of a diagnosed EMPS by the measure of its publication: inverse dynamics along the recording.

    realitygap diagnose scenarios/emps/scenario.yaml -e mujoco -o DIR
    REALITYGAP_DATA=... python tests/bench_emps.py DIR/diagnosis.json

Positions are filtered forward and backward below 100 Hz, velocities and accelerations are their differences, and both
forces are decimated to 100 Hz (Janot, Gautier, Brunot 2019). Told is the second half, which a diagnosis does not fit:
of the published values, of the diagnosed ones, and of what a plain regression of the first half gives.
"""

import argparse
import json
import os
import sys
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.signal import butter, decimate, filtfilt

H, BELOW, TENTH = 1e-3, 100.0, 10
"""Period of the samples [s], what positions are filtered below [Hz], and what forces are decimated by."""
EDGE = 20
"""Decimated samples at either end that filters tell poorly."""
PUBLISHED = {"mass": 95.1089, "viscous": 203.5034, "forward": 20.3935 - 3.1648, "backward": 20.3935 + 3.1648}
Values = dict[str, float]


def columns(position: NDArray[np.float64]) -> NDArray[np.float64]:
    """What each of mass, viscous and dry friction gives per unit, each way: (t,) -> (t, 5)."""
    q = filtfilt(*butter(4, 2.0 * BELOW * H), position)
    v = np.gradient(q, H)
    ahead = v > 0
    return np.column_stack([np.gradient(v, H), v * ahead, v * ~ahead, 1.0 * ahead, -1.0 * ~ahead])


def amounts(of: Values) -> NDArray[np.float64]:
    """The amounts of these of some values. Shape (5,)."""
    share = of.get("asymmetry", 0.0)
    ways = [of["viscous"] * (1.0 + share), of["viscous"] * (1.0 - share)]
    return np.array([of["mass"], *ways, of["forward"], of["backward"]])


def diagnosed(path: Path) -> Values:
    """What a diagnosis says of the drive, named or adjusted."""
    said = json.loads(path.read_text(encoding="utf-8"))
    told = (*said["findings"], *said["adjusted"])
    found = {f["effect"]: {n: p["value"] for n, p in f["parameters"].items()} for f in told}
    mass, viscous = found["link_mass"]["mass"], found["viscous_friction"]["coefficient"]
    return {"mass": mass, "viscous": viscous, **found["direction_friction"]}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("diagnosis", type=Path)
    args = parser.parse_args()
    data = pd.read_csv(Path(os.environ["REALITYGAP_DATA"]) / "emps" / "estimation.csv")
    all_, force = columns(data["position"].to_numpy(float)), data["force"].to_numpy(float)
    half = len(force) // 2

    def slow(signal: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray(decimate(signal, TENTH, axis=0, zero_phase=True))[EDGE:-EDGE]

    plain = np.linalg.lstsq(slow(all_[:half]), slow(force[:half]))[0]
    measured = slow(force[half:])
    for name, of in (
        ("published, without asymmetry", amounts(PUBLISHED)),
        ("diagnosed", amounts(diagnosed(args.diagnosis))),
        ("plain regression of the first half", plain),
    ):
        error = float(np.linalg.norm(measured - slow(all_[half:] @ of)) / np.linalg.norm(measured))
        mass, forward, backward, *dry = of
        sys.stdout.write(
            f"{name}: {100 * error:.2f} % (mass {mass:.2f} kg, viscous {forward:.1f} and {backward:.1f} N·s/m, "
            f"dry {dry[0]:.2f} and {dry[1]:.2f} N)\n"
        )


if __name__ == "__main__":
    main()
