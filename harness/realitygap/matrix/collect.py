"""The result folder: a pure function of the files of its cells."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import pandas as pd

from realitygap.compare.budget import not_judged, over_budget
from realitygap.compare.comparison import failure
from realitygap.compare.row import outcome_told, slug
from realitygap.compare.size import told
from realitygap.compare.table import table, to_csv
from realitygap.files.whole import write_whole
from realitygap.matrix.manifest import write_manifest
from realitygap.matrix.matrix_file import MatrixFile
from realitygap.matrix.store import Store
from realitygap.matrix.task import Outcome, Task, read_outcome, unpack


@dataclass(frozen=True)
class Collected:
    """What a run or a matrix gave.

    Attributes:
        name: of the scenario or the matrix.
        gaps: the table.
        cells: every cell with what became of it, in the order of the tasks.
        failures: sentences on what could not be drawn of it.
    """

    name: str
    gaps: pd.DataFrame
    cells: list[tuple[Task, Outcome]]
    failures: list[str] = field(default_factory=list)

    @property
    def has_result(self) -> bool:
        """Whether any cell was simulated to its end."""
        return any(outcome.outcome == "ok" for _, outcome in self.cells)

    def excess(self, budget: Mapping[str, float]) -> dict[str, list[str]]:
        """Sentences on the cells that exceed a budget, by the cell's key."""
        found = {}
        for task, outcome in self.cells if budget else ():
            lines = over_budget(table(outcome.rows), budget)
            if lines:
                which = ", ".join(f"{key} {value}" for key, value in task.axes.items())
                found[task.key] = [f"{line} ({which})" if which else line for line in lines]
        return found

    def not_judged(self, budget: Mapping[str, float]) -> list[str]:
        """Sentences on the budgets that nothing was measured for."""
        return not_judged(self.gaps, budget)


def collect(
    matrix: MatrixFile,
    tasks: Sequence[Task],
    undone: Mapping[str, str],
    store: Store,
    out: Path,
    warnings: Sequence[str] = (),
) -> Collected:
    """Write table, timings, manifest and traces.

    Args:
        matrix: what the cells are of.
        tasks: all cells.
        undone: what happened to the cells that have no file, by key.
        store: the files of the others.
        out: an empty folder.
        warnings: sentences on likely mistakes in the scenarios, for the page.
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
        {slug(o.cell): outcome_told(o.outcome, o.note) for _, o in cells if o.outcome != "ok"},
        [f for f in files if f.endswith(".mcap")],
        warnings,
        told([t.motion for t, o in cells if t.traces is True and o.outcome == "ok"], whole=False),
    )
    return Collected(matrix.matrix.name, gaps, cells)


def _timings(cells: Sequence[tuple[Task, Outcome]]) -> pd.DataFrame:
    rows = []
    for task, o in cells:
        if o.steps:
            first = task.motion.experiments[0]
            seconds = o.steps / o.cell.step_rate if first.followed is None else first.duration
            speed = seconds / o.wall
            rows.append({**vars(o.cell), "wall_seconds": o.wall, "real_time_factor": speed, "steps": o.steps})
    return pd.DataFrame(rows)
