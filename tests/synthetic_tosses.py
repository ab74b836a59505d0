"""Tosses of a cube that slides flat on the ground, or tumbles over it, simulated at a finer step: synthetic."""

from pathlib import Path

import numpy as np
import pandas as pd
from realitygap.scenario.file import load_scenario
from realitygap.simulate.experiment import experiments, simulate

CUBE = """<robot name="cube"><link name="body"><inertial><mass value="0.4"/>
<inertia ixx="6e-4" iyy="6e-4" izz="6e-4" ixy="0" ixz="0" iyz="0"/></inertial>
<collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link></robot>"""
SCENARIO = """
name: tosses
robot: {urdf: cube.urdf, base: free}
ground: {friction: %s}
physics: {step_rate: 1000}
recordings:
  runs:
    - {path: "toss_[0-3].csv", use: train}
    - {path: "toss_[4-5].csv", use: held_out}
"""
COLUMNS = ["x", "y", "z", "qw", "qx", "qy", "qz", "vx", "vy", "vz", "wx", "wy", "wz"]


def write_tosses(folder: Path, friction: float, *, tumbling: str = "") -> Path:
    """Six noisy tosses on a ground of this friction, and a scenario that says 0.8. Returns the scenario's path.

    Those that slide are made in DART, those that tumble in the engine of that name.
    """
    (folder / "cube.urdf").write_text(CUBE)
    rng = np.random.default_rng(4)
    time = np.arange(0.0, 1.0 if tumbling else 0.5, 1 / 150)
    path = folder / "scenario.yaml"
    for n in range(6):
        start = [*rng.uniform(-1, 1, 2), 0.051, 1, 0, 0, 0]  # flat: it slides and does not tumble
        first = [*start, *rng.uniform(0.5, 1.5, 2), 0, 0, 0, 0]
        if tumbling:
            first[2], first[9:] = 0.25, [0.0, *rng.uniform(-6, 6, 3)]
        pd.DataFrame(np.column_stack([time, np.tile(first, (len(time), 1))]), columns=["time", *COLUMNS]).to_csv(
            folder / f"toss_{n}.csv", index=False
        )
    path.write_text(SCENARIO % friction)
    for experiment in experiments(load_scenario(path)):
        trace = simulate(experiment, tumbling or "dart", step_rate=4000).trace.at(time)
        columns = (trace.base_position, trace.base_quaternion, trace.base_linear, trace.base_angular)
        values = np.hstack([c for c in columns if c is not None])
        values[1:, :7] += (1e-4 if tumbling else 1e-3) * rng.normal(size=values[1:, :7].shape)
        frame = pd.DataFrame(np.column_stack([time, values]), columns=["time", *COLUMNS])
        frame.to_csv(folder / f"{experiment.name}.csv", index=False)
    path.write_text(SCENARIO % 0.8)
    return path
