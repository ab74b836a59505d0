"""The matrix file: which scenarios, which engines, which axes, and what is left out."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, WithJsonSchema

from realitygap.files.errors import InputError
from realitygap.files.validation import validate
from realitygap.files.yaml_file import load_yaml
from realitygap.scenario.engine_names import engine_names
from realitygap.scenario.file import ScenarioFile, load_scenario, resolve_path
from realitygap.scenario.section import Patterns, Positive, Section
from realitygap.scenario.which_file import check_kind

NAMED_AXES = {  # axis -> scenario key; `revision` names an entry of the scenario's `revisions`
    "revision": "robot.urdf",
    "ground": "ground",
    "step_rate": "physics.step_rate",
    "solver_iterations": "physics.solver_iterations",
}
OTHER_AXES = ("scenario", "engine", "recording")
"""What tells cells apart without being an axis of the file; known in `leave_out`."""


def _listed(value: object) -> object:
    return value if isinstance(value, list) else [value]


LONGEST = 1e6
"""[s] A cell of a scenario that runs alone may take as long as anybody waits."""
ANY_BUT_NONE = {"not": {"type": "array", "maxItems": 0}}
"""One value, or a list that is not empty."""
Values = Annotated[list[Any], BeforeValidator(_listed), Field(min_length=1), WithJsonSchema(ANY_BUT_NONE)]


class Matrix(Section):
    """Every combination of scenario, recording, engine and axis values is one cell, but for those left out."""

    name: str = Field(description="name of the matrix")
    scenarios: Patterns = Field(description="scenario files, relative to this file")
    engines: Patterns | None = Field(default=None, description="engines (default: all installed)")
    recordings: Patterns = Field(default=["*"], description="patterns over the recordings' names")
    axes: dict[str, Values] = Field(
        default={}, description="revision, ground, step_rate, solver_iterations or any dotted scenario key: its values"
    )
    leave_out: list[dict[str, Any]] = Field(
        default=[], description="combinations that are not run: axis, engine, scenario or recording to value or pattern"
    )
    floors: bool = Field(default=True, description="simulate again with half the step for the numerical floor")
    traces: bool | Literal["whole"] = Field(
        default=True,
        description="write the traces of every cell (Parquet and MCAP); those above 500 MB are thinned but for `whole`",
    )
    time_limit: Positive = Field(default=300.0, le=LONGEST, description="seconds after which a cell counts as hung")


@dataclass(frozen=True)
class MatrixFile:
    """A matrix, the file that it came from, and its scenarios."""

    path: Path
    matrix: Matrix
    scenarios: tuple[ScenarioFile, ...]

    def engine_names(self) -> list[str]:
        """The engines of the matrix, or all that are installed.

        Raises:
            InputError: for an engine that does not exist or is not installed.
        """
        return engine_names(self.matrix.engines or [], f"{self.path}: engines")


def load_matrix(path: Path) -> MatrixFile:
    """The matrix in a YAML file.

    Raises:
        InputError: one sentence with file, key, what was found and what was expected.
    """
    raw = load_yaml(path)
    check_kind(path, "a matrix", raw)
    matrix = validate(path, Matrix, raw)
    known = [*OTHER_AXES, *matrix.axes]
    for i, combination in enumerate(matrix.leave_out):
        for key in combination:
            if key not in known:
                raise InputError(
                    f"{path}: leave_out[{i}]: {key} is no axis of this matrix; expected one of {', '.join(known)}"
                )
    for axis, values in matrix.axes.items():
        if axis not in NAMED_AXES and "." not in axis:
            named = ", ".join(NAMED_AXES)
            raise InputError(f"{path}: axes: found {axis}; expected {named} or a dotted scenario key")
        if len({repr(v) for v in values}) < len(values):
            raise InputError(f"{path}: axes.{axis}: a value stands twice in {values}; expected each once")
    paths = [resolve_path(path, s, f"scenarios[{i}]") for i, s in enumerate(matrix.scenarios)]
    for i, file in enumerate(paths):
        if not file.exists():
            raise InputError(f"{path}: scenarios[{i}]: {file} does not exist; expected a scenario file")
    return MatrixFile(path, matrix, tuple(load_scenario(p) for p in paths))


def matrix_of(file: ScenarioFile, engines: Sequence[str] = (), *, whole: bool = False) -> MatrixFile:
    """The matrix of one scenario as it is, in the engines that are named or in all that are installed.

    `whole` keeps traces whole, however large they are.
    """
    matrix = Matrix(
        name=file.scenario.name,
        scenarios=[file.path.name],
        engines=list(engines) or None,
        time_limit=LONGEST,
        traces="whole" if whole else True,
    )
    return MatrixFile(file.path, matrix, (file,))
