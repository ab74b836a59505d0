"""One cell as a piece of work: everything it needs, and its result as one small file."""

import io
import json
import tempfile
import zipfile
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Literal

from realitygap.compare.comparison import Comparison, RepeatedMotion, cell_of, compare, failure
from realitygap.compare.row import Cell, Row
from realitygap.compare.traces import write_traces
from realitygap.files.unfinished import ELSEWHERE, part_folder
from realitygap.scenario.file import ScenarioFile

Traces = bool | Literal["whole"]
"""Whether the traces of a cell are written, and whether whole, however large they are."""
RECORD = "cell.json"
EPOCH = (1980, 1, 1, 0, 0, 0)


@dataclass(frozen=True)
class Task:
    """One cell that is to be computed, with all its input: nothing else is read.

    Attributes:
        key: digest of everything that the result depends on.
        file: the scenario with the axis values of this cell.
        motion: what is simulated and what was measured.
        engine: its name.
        revision: name of the robot's revision; "" where the matrix has no such axis.
        axes: the axis values of this cell by name, for people.
        floors, traces: as in the matrix file.
    """

    key: str
    file: ScenarioFile
    motion: RepeatedMotion
    engine: str
    revision: str
    axes: dict[str, Any]
    floors: bool
    traces: Traces

    @property
    def cell(self) -> Cell:
        """The key columns of the table."""
        return cell_of(self.motion, self.engine, self.revision)

    @property
    def title(self) -> str:
        """The cell in words."""
        parts = [self.engine, self.motion.name, *(f"{k.split('.')[-1]} {v}" for k, v in self.axes.items())]
        return " ".join(parts)


@dataclass(frozen=True)
class Outcome:
    """What became of a cell: the content of `cell.json`."""

    cell: Cell
    outcome: str
    note: str = ""
    rows: list[Row] = field(default_factory=list)
    settings: dict[str, Any] = field(default_factory=dict)
    wall: float = float("nan")
    steps: int = 0


def compute(task: Task) -> bytes:
    """Simulate and compare one cell. The result is a zip file with the record and the traces."""
    whole = task.traces == "whole"
    done = compare(task.motion, task.engine, floors=task.floors, revision=task.revision, whole=whole)
    return packed(task, done)


def lost(task: Task, outcome: str, note: str) -> bytes:
    """The result of a cell that could not tell itself what happened: it crashed or took too long."""
    return packed(task, failure(task.cell, task.motion, outcome, note))


def packed(task: Task, done: Comparison) -> bytes:
    """A comparison as a zip file, the same bytes for the same comparison but for its timing."""
    rollout = done.rollout
    record = {
        "schema": 2,
        "cell": asdict(done.cell),
        "outcome": done.outcome,
        "note": done.note,
        "rows": [asdict(r) for r in done.rows],
        "settings": done.settings,
        "wall": rollout.wall if rollout else float("nan"),
        "steps": rollout.steps if rollout else 0,
    }
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w") as archive:
        _add(archive, RECORD, json.dumps(record, default=str, ensure_ascii=False).encode())
        if task.traces:
            with part_folder(Path(tempfile.gettempdir()), ELSEWHERE) as folder:
                write_traces(folder, done, task.motion.experiments[0].plant.model)
                for path in sorted(p for p in folder.rglob("*") if p.is_file()):
                    _add(archive, path.relative_to(folder).as_posix(), path.read_bytes())
    return out.getvalue()


def _add(archive: zipfile.ZipFile, name: str, content: bytes) -> None:
    packed_already = name.endswith(".parquet")
    how = zipfile.ZIP_STORED if packed_already else zipfile.ZIP_DEFLATED
    archive.writestr(zipfile.ZipInfo(name, EPOCH), content, how)


def read_outcome(data: bytes) -> Outcome:
    """The record of a cell's file.

    Raises:
        ValueError: for a file that is not one.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            damaged = archive.testzip()
            if damaged is not None:
                raise ValueError(f"{damaged} is damaged")
            record = json.loads(archive.read(RECORD))
        return Outcome(
            cell=Cell(**record["cell"]),
            outcome=record["outcome"],
            note=record["note"],
            rows=[Row(**r) for r in record["rows"]],
            settings=record["settings"],
            wall=record["wall"],
            steps=record["steps"],
        )
    except Exception as error:  # a damaged archive makes its reader trip over anything
        raise ValueError(f"is not the file of a cell ({type(error).__name__}: {error})") from None


def unpack(data: bytes, folder: Path) -> list[str]:
    """Write the traces of a cell's file below a result folder. Returns their names."""
    names = []
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        for name in archive.namelist():
            if name != RECORD:
                archive.extract(name, folder)
                names.append(name)
    return names
