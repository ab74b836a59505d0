"""How many sweeps of quickStep, and at which step rate? `python scenarios/ode_iterations/study.py`

The question the thesis left open. Runs the two matrices beside this file (what is there already is not computed again)
and writes ode_iterations.csv, .md and .svg into results/reference. Needs REALITYGAP_DATA and libode.
"""

from pathlib import Path

import numpy as np
import pandas as pd
from page import write_page
from realitygap.cli.results import make
from realitygap.compare.table import slug
from realitygap.files.progress import Progress
from realitygap.matrix.matrix import Settings
from realitygap.matrix.matrix_file import load_matrix
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore

HERE = Path(__file__).parent
RESULTS = HERE.parents[1] / "results"
FINEST = (None, 2000.0)
"""Iterations (None: solved to the end) and step rate [Hz] of the simulation that the others are measured against."""


def joint_motion(path: Path) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Time [s], joint angles [rad] and speeds [rad/s] of a simulated trace. Shapes (k,), (k, n) and (k, n)."""
    store = get_typestore(Stores.ROS2_HUMBLE)
    with AnyReader([path], default_typestore=store) as reader:
        wanted = [c for c in reader.connections if c.topic == "/simulated/joint_states"]
        rows = [(t, reader.deserialize(m, c.msgtype)) for c, t, m in reader.messages(wanted)]
    time = np.array([t for t, _ in rows]) / 1e9
    return time, np.array([m.position for _, m in rows]), np.array([m.velocity for _, m in rows])


def cheering() -> pd.DataFrame:
    """Distance from the finest simulation and speed of the robot that has come to rest."""
    matrix, out = load_matrix(HERE / "cheering.yaml"), RESULTS / "runs" / "ode_cheering"
    collected = make(matrix, out, Settings(retry_crashed=True), Progress())
    traces = RESULTS / "runs" / "ode_cheering" / "traces"
    done = {
        (o.cell.solver_iterations, o.cell.step_rate): joint_motion(traces / f"{slug(o.cell)}.mcap")
        for _, o in collected.cells
        if o.outcome == "ok"
    }
    time, position, _ = done[FINEST]
    rows = []
    for _, o in collected.cells:
        row = {"motion": "cheering", "solver_iterations": o.cell.solver_iterations, "step_rate": o.cell.step_rate}
        row |= {"outcome": o.outcome, "distance_deg": np.inf, "rest_speed_deg_s": np.inf}
        if o.outcome == "ok":
            t, q, w = done[o.cell.solver_iterations, o.cell.step_rate]
            at = np.column_stack([np.interp(time, t, x) for x in q.T])
            row["distance_deg"] = np.degrees(np.sqrt(np.mean((at - position) ** 2)))
            row["rest_speed_deg_s"] = np.degrees(np.sqrt(np.mean(w[t > t[-1] - 0.5] ** 2)))
        rows.append(row)
    return pd.DataFrame(rows)


def kicks() -> pd.DataFrame:
    """Mean gap to the measured joint angles, over the recordings."""
    matrix, out = load_matrix(HERE / "kicks.yaml"), RESULTS / "runs" / "ode_kicks"
    collected = make(matrix, out, Settings(retry_crashed=True), Progress())
    gaps = collected.gaps
    gaps = gaps[(gaps.signal == "position") & gaps.group.isin(["moving", "unmoving"])]
    keys = ["solver_iterations", "step_rate"]
    table = gaps.groupby([*keys, "group"], dropna=False).mean_abs.mean().unstack("group")
    table.columns = [f"{group}_gap_deg" for group in table.columns]
    bad = gaps.groupby(keys, dropna=False).outcome.agg(lambda x: next((o for o in x if o != "ok"), "ok"))
    return table.join(bad).reset_index().assign(motion="kicks")


def main() -> None:
    table = pd.concat([cheering(), kicks()])
    table["solver_iterations"] = table.solver_iterations.astype("Int64")
    order = ["motion", "step_rate", "solver_iterations"]
    columns = [*order, "outcome", "distance_deg", "rest_speed_deg_s", "moving_gap_deg", "unmoving_gap_deg"]
    out = RESULTS / "reference"
    out.mkdir(parents=True, exist_ok=True)
    table.sort_values(order)[columns].to_csv(
        out / "ode_iterations.csv", index=False, float_format="%.4g", lineterminator="\n"
    )
    write_page(out)


if __name__ == "__main__":
    main()
