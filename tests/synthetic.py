"""Synthetic result folders: invented gaps and traces in the form that a run writes. They stand for no robot."""

import itertools
import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from realitygap.compare.comparison import Comparison
from realitygap.compare.gap import differences
from realitygap.compare.row import COLUMNS, Cell, Row, failed, row, slug
from realitygap.compare.table import table, to_csv
from realitygap.compare.traces import write_traces
from realitygap.files.whole import write_whole
from realitygap.trace.trace import Trace
from realitygap_engines.model.robot import Joint, Link, Model


def model(joints: Sequence[str]) -> Model:
    links = tuple(Link(f"link_{i}", 1.0, np.zeros(3), np.eye(3)) for i in range(len(joints) + 1))
    return Model(
        "synthetic", links, tuple(Joint(n, False, i, np.eye(4), np.eye(3)[2]) for i, n in enumerate(joints)), False
    )


def trace(joints: Sequence[str], error: float, seed: int, *, command: bool = False) -> Trace:
    """Even joints swing, odd ones hold; `error` [rad] is added as a late and noisy response."""
    random = np.random.default_rng(seed)
    time = np.linspace(0.0, 4.0, 801)
    swing = np.array([0.6 * (i % 2 == 0) for i in range(len(joints))])
    position = swing * np.sin(2 * time[:, None]) + error * (1 + 0.3 * random.standard_normal(len(joints)))
    position = position * (1 + 0 * time[:, None]) + error * 0.2 * np.sin(9 * time[:, None])
    velocity = np.gradient(position, time, axis=0)
    return Trace(
        time=time,
        joints=tuple(joints),
        position=position,
        velocity=velocity,
        effort=2 * velocity,
        command=swing * np.sin(2 * time[:, None]) if command else None,
    )


def cell(engine: str = "mujoco", **changes: object) -> Cell:
    values: dict[str, object] = {
        "scenario": "synthetic",
        "robot_revision": "new",
        "engine": engine,
        "engine_version": "1.0",
        "ground": "flat",
        "recorded_ground": "",
        "step_rate": 1000.0,
        "solver_iterations": None,
        "overrides": "",
        "recording": "swing",
        "use": "",
    }
    return Cell(**(values | changes))  # type: ignore[arg-type]


Gaps = dict[Any, float]
"""Gaps by engine, changes of its cell (name, value), signal and group."""


def planted(gaps: Gaps, *, noise: float = 0.01, numerical: float = 0.01) -> pd.DataFrame:
    """A table of single joints from {(engine, {changes}, signal, group): gap}; an infinite gap has diverged."""
    rows = []
    for (engine, changes, signal, group), gap in gaps.items():
        unit = {"position": "deg", "velocity": "deg/s", "effort": "N·m"}[str(signal)]
        outcome = "ok" if np.isfinite(gap) else "diverged"
        rows.append(
            Row(
                **vars(cell(str(engine), **dict(changes))),
                joint=f"{group}_joint",
                group=str(group),
                signal=str(signal),
                unit=unit,
                mean_abs=gap,
                median_abs=gap,
                p95_abs=gap,
                max_abs=gap,
                noise_floor=noise,
                numerical_floor=numerical,
                outcome=outcome,
                note="" if outcome == "ok" else "diverged at 1.2 s at left_knee: not finite",
            )
        )
    return table(rows)


def write_planted(
    folder: Path, frame: pd.DataFrame, manifest: dict[str, object] | None = None, timings: str = ""
) -> Path:
    write_whole(folder / "gaps.csv", to_csv(frame))
    write_whole(folder / "manifest.json", json.dumps(manifest or {}))
    if timings:
        write_whole(folder / "timings.csv", timings)
    return folder


def write_cell(folder: Path, one: Cell, simulated: Trace, measured: Trace | None) -> Path:
    """The traces of one cell. Returns the Parquet file."""
    robot = model(simulated.joints)
    write_traces(folder, Comparison(one, [], "ok", simulated=simulated, measured=measured), robot)
    return folder / "traces" / f"{slug(one)}.parquet"


def write_folder(
    folder: Path,
    *,
    joints: Sequence[str],
    cells: Sequence[Cell],
    error: Callable[[Cell], float],
    traces: bool = True,
    virtual: bool = False,
) -> Path:
    """A whole folder with traces and timings; a cell whose error is infinite has diverged."""
    robot = model(joints)
    rows, timings = [], []
    for number, one in enumerate(cells):
        measured = trace(joints, 0.0, 0, command=True)
        wrong = error(one)
        simulated = trace(joints, wrong if np.isfinite(wrong) else 0.0, number)
        for d in differences(robot, simulated, measured):
            noise = 0.05 if d.signal == "position" else 0.5
            if np.isfinite(wrong):
                rows.append(row(one, d, noise, 0.02))
            else:
                rows.append(failed(one, d, noise, "diverged", "diverged at 1.2000 s at knee: not finite"))
        if np.isfinite(wrong):
            if traces:
                write_cell(folder, one, simulated, measured)
            speed = {"mujoco": 40.0, "dart": 9.0, "drake": 5.0, "pybullet": 11.0}[one.engine] * 1000 / one.step_rate
            timings.append({**vars(one), "wall_seconds": 4 / speed, "real_time_factor": speed, "steps": 4000})
    frame = pd.DataFrame([vars(r) for r in rows], columns=COLUMNS) if not rows else table(rows)
    engines = sorted({c.engine for c in cells})
    manifest = {
        "schema": 1,
        "scenario": "synthetic",
        "command_line": ["matrix", "synthetic.yaml"],
        "versions": dict.fromkeys(engines, "1.0"),
        "settings": {e: {"timestep": 0.001, "solver": f"the solver of {e}"} for e in engines},
        "capabilities": {e: {"armature": {"level": "emulated", "how": "outside the engine"}} for e in engines},
        "inputs": {f"{'a_long_folder/' * 8}synthetic.urdf": "0" * 64},
        "notes": {"model": ["Synthetic: invented numbers, no robot."]},
        "virtual": virtual,
    }
    write_planted(folder, frame, manifest)
    write_whole(folder / "timings.csv", to_csv(pd.DataFrame(timings)))
    return folder


def grid(**axes: Sequence[object]) -> list[Cell]:
    """Cells of all combinations."""
    names = list(axes)
    return [
        cell(**dict(zip(names, values, strict=True)))  # type: ignore[arg-type]
        for values in itertools.product(*axes.values())
    ]
