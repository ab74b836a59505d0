"""The result folder of a matrix: a pure function of the files of its cells."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from realitygap.compare.comparison import failure
from realitygap.compare.manifest import write_manifest
from realitygap.compare.table import slug, table, to_csv
from realitygap.files.whole import write_whole
from realitygap.matrix.matrix_file import MatrixFile
from realitygap.matrix.store import Store
from realitygap.matrix.task import Outcome, Task, read_outcome, unpack


@dataclass(frozen=True)
class Collected:
    """What a matrix gave: the table, and every cell with what became of it, in the order of the tasks."""

    gaps: pd.DataFrame
    cells: list[tuple[Task, Outcome]]


def collect(matrix: MatrixFile, tasks: Sequence[Task], undone: dict[str, str], store: Store, out: Path) -> Collected:
    """Write table, timings, manifest, curves and traces.

    Args:
        matrix: what the cells are of.
        tasks: all cells.
        undone: what happened to the cells that have no file, by key.
        store: the files of the others.
        out: an empty folder.
    """
    cells: list[tuple[Task, Outcome]] = []
    files: list[str] = []
    for task in tasks:
        if task.key in undone:
            failed = failure(task.cell, task.motion, "crashed", undone[task.key])
            cells.append((task, Outcome(task.cell, "crashed", undone[task.key], failed.rows)))
            continue
        data = store.read(task.key)
        cells.append((task, read_outcome(data)))
        files += unpack(data, out)
    gaps = table(r for _, o in cells for r in o.rows)
    write_whole(out / "gaps.csv", to_csv(gaps))
    write_whole(out / "timings.csv", to_csv(_timings(cells)))
    write_manifest(
        out,
        matrix.matrix.name,
        ((t.file, t.motion) for t in tasks),
        [(o.cell, o.settings) for _, o in cells if o.settings],
        {slug(o.cell): f"{o.outcome}: {o.note}" for _, o in cells if o.outcome != "ok"},
        [f for f in files if f.startswith("traces/")],
    )
    return Collected(gaps, cells)


def _timings(cells: Sequence[tuple[Task, Outcome]]) -> pd.DataFrame:
    rows = []
    for _, o in cells:
        if o.steps:
            speed = o.steps / o.cell.step_rate / o.wall
            rows.append({**vars(o.cell), "wall_seconds": o.wall, "real_time_factor": speed, "steps": o.steps})
    return pd.DataFrame(rows)
