"""Where the thrown cube's centre of mass is, as its free flights alone tell: no engine, no contact, no diagnosis.

    REALITYGAP_DATA=... python tests/bench_cube_flight.py

Until it touches the ground, the centre of mass of a body follows a parabola, and what was tracked turns about it: its
position is p(t) = a + b·t - ½·g·t² - R(t)·c, with c the centre of mass in the tracked frame. Every toss has its own a
and b, and all have one c. The errors are those of tosses as a whole (Liang & Zeger 1986).
"""

import os
from pathlib import Path

import numpy as np
import pandas as pd
from realitygap_engines import GRAVITY
from scipy.spatial.transform import Rotation

SIDE = 0.1048  # m
ABOVE = 0.005  # m: the lowest corner is at least so high where the cube flies
FEWEST = 8  # samples of a flight
POSITION, ORIENTATION = ["x", "y", "z"], ["qx", "qy", "qz", "qw"]


def flight(toss: pd.DataFrame) -> tuple[np.ndarray, np.ndarray] | None:
    """What c does to the positions of one flight, free of what a and b do, and these positions: (3·t, 3), (3·t,)."""
    turned = Rotation.from_quat(toss[ORIENTATION].to_numpy()).as_matrix()
    lowest = toss["z"].to_numpy() - 0.5 * SIDE * np.abs(turned[:, 2]).sum(axis=1)
    flying = int(np.argmin(np.append(lowest > ABOVE, False)))
    if flying < FEWEST:
        return None
    time = toss["time"].to_numpy()[:flying] - toss["time"].iloc[0]
    position = toss[POSITION].to_numpy()[:flying]
    position[:, 2] += 0.5 * GRAVITY * time**2
    own, _ = np.linalg.qr(np.column_stack([np.ones(flying), time]))

    def free(columns: np.ndarray) -> np.ndarray:
        return np.asarray(columns - own @ (own.T @ columns))

    does = np.concatenate([free(-turned[:flying, axis]) for axis in range(3)])
    return does, np.concatenate([free(position[:, [axis]])[:, 0] for axis in range(3)])


def main() -> None:
    """Print the centre of mass with its standard errors."""
    files = sorted((Path(os.environ["REALITYGAP_DATA"]) / "cube_toss").glob("toss_*.csv"))
    flights = [found for f in files if (found := flight(pd.read_csv(f))) is not None]
    normal = np.linalg.inv(sum(does.T @ does for does, _ in flights))
    centre = normal @ sum(does.T @ moved for does, moved in flights)
    scores = np.array([does.T @ (moved - does @ centre) for does, moved in flights])
    error = np.sqrt(np.diag(normal @ (scores.T @ scores) @ normal))
    told = ", ".join(f"{axis} {1e3 * c:.2f} ± {1e3 * e:.2f}" for axis, c, e in zip("xyz", centre, error, strict=True))
    print(f"{len(flights)} flights: the centre of mass is at {told} mm from what was tracked (± one standard error)")


if __name__ == "__main__":
    main()
