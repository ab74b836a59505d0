"""The traces of a cell as files: whole as Parquet, for page, figures and whoever computes on; as MCAP for viewers."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from realitygap_engines.errors import in_a_line
from realitygap_engines.model.robot import Model

from realitygap.compare.comparison import Comparison
from realitygap.compare.row import Cell, slug
from realitygap.compare.size import thinned
from realitygap.files.errors import InputError
from realitygap.trace.mcap import write_mcap
from realitygap.trace.parquet import read_about, read_parquet, write_parquet
from realitygap.trace.trace import Trace

FOLDER = "traces"
"""Below a result folder."""
SIMULATED, MEASURED = "simulated", "measured"


@dataclass(frozen=True)
class JointKind:
    """A joint as far as a comparison needs it: its name and whether it slides."""

    name: str
    prismatic: bool


@dataclass(frozen=True)
class CellTraces:
    """What was simulated and measured in one cell.

    Attributes:
        cell: what was simulated.
        joints: those of the robot, in the order of the simulated columns.
        simulated: on every step; of repetitions, their mean on the measured clock.
        measured: in the window, the mean of repetitions; None where nothing was.
        boxes: of traces that were thinned, the statistics of all samples: signal -> joint -> numbers of a box plot.
    """

    cell: Cell
    joints: tuple[JointKind, ...]
    simulated: Trace
    measured: Trace | None
    boxes: dict[str, dict[str, list[float]]] | None = None


def write_traces(folder: Path, done: Comparison, model: Model) -> None:
    """Write `traces/CELL.parquet` and `traces/CELL.mcap` below a folder, where the cell was simulated.

    Of a motion that was recorded several times, the Parquet file holds every repetition's own simulation, too. A cell
    that was not kept whole is thinned, and its file tells the box plots of all samples.
    """
    if done.simulated is None:
        return
    traces = {SIMULATED: done.simulated}
    if done.measured is not None:
        traces[MEASURED] = done.measured
    path = folder / FOLDER / f"{slug(done.cell)}.parquet"
    slides = [j.name for j in model.joints if j.prismatic]
    each = {f"{SIMULATED} {name}": trace for name, trace in done.repetitions.items()}
    about: dict[str, Any] = {"cell": asdict(done.cell)}
    if done.boxes is not None:
        kept, about["boxes"] = thinned(traces | each), done.boxes
        traces, each = {n: kept[n] for n in traces}, {n: kept[n] for n in each}
    write_mcap(path.with_suffix(".mcap"), traces)
    write_parquet(path, traces | each, about, slides)


def add_traces(path: Path, kept: Mapping[str, Trace], viewed: Mapping[str, Trace]) -> None:
    """Add traces to the files of a cell: some to its Parquet file, and to its MCAP file those that viewers can show."""
    about, traces = read_about(path), read_parquet(path)
    own = {key: value for key, value in about.items() if key in ("cell", "boxes")}
    write_parquet(path, traces | dict(kept), own, about["slides"])
    write_mcap(path.with_suffix(".mcap"), {n: traces[n] for n in (SIMULATED, MEASURED) if n in traces} | dict(viewed))


def cell_of_traces(path: Path) -> Cell:
    """The cell that a Parquet file is of; its traces are not read.

    Raises:
        InputError: for a damaged file.
    """
    with _undamaged(path):
        return Cell(**read_about(path)["cell"])


def read_traces(path: Path, signals: Sequence[str] = Trace.SIGNALS) -> CellTraces:
    """The traces of a cell from its Parquet file; signals that are not asked for are None.

    Raises:
        InputError: for a damaged file.
    """
    with _undamaged(path):
        about = read_about(path)
        found = read_parquet(path, only=(SIMULATED, MEASURED), signals=signals)
        simulated = found[SIMULATED]
        joints = tuple(JointKind(name, name in about["slides"]) for name in simulated.joints)
        return CellTraces(Cell(**about["cell"]), joints, simulated, found.get(MEASURED), about.get("boxes"))


@contextmanager
def _undamaged(path: Path) -> Iterator[None]:
    try:
        yield
    except Exception as error:  # a damaged file makes its reader trip over anything
        raise InputError(
            f"{path}: is not a whole file of traces ({type(error).__name__}: {in_a_line(error)}); take it away or run "
            "again"
        ) from None
