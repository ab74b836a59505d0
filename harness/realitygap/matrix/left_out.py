"""The combinations that a matrix leaves out, and whether what they name is there at all."""

from collections.abc import Collection, Sequence
from fnmatch import fnmatchcase
from typing import Any

import realitygap_engines as engines

from realitygap.files.errors import InputError, did_you_mean
from realitygap.files.found import shown
from realitygap.matrix.matrix_file import Matrix, MatrixFile
from realitygap.matrix.task import Task


def left_out(matrix: Matrix, task: Task) -> bool:
    """Whether a cell is one of those that are not run."""
    named = {"scenario": task.file.scenario.name, "engine": task.engine, "recording": task.motion.name, **task.axes}
    return any(all(_matches(named[k], v) for k, v in c.items()) for c in matrix.leave_out)


def check_left_out(matrix: MatrixFile, recorded: Collection[str]) -> None:
    """Make sure that every value in `leave_out` names something: a typo would run what was to be left out.

    An engine that is known but not of this matrix, and a recording that its `recordings` do not choose, name something.

    Args:
        matrix: the matrix.
        recorded: the names of its motions.

    Raises:
        InputError: for a value that names nothing.
    """
    if not matrix.matrix.leave_out:
        return
    known: dict[str, Sequence[Any]] = {
        "scenario": [file.scenario.name for file in matrix.scenarios],
        "engine": sorted(engines.ENGINES),
        "recording": sorted(recorded),
        **matrix.matrix.axes,
    }
    unchosen = [case.name for file in matrix.scenarios for case in file.cases() if not _chosen(matrix, case.name)]
    for i, combination in enumerate(matrix.matrix.leave_out):
        for key, wanted in combination.items():
            for value in wanted if isinstance(wanted, list) else [wanted]:
                others = unchosen if key == "recording" else []
                if not any(_matches(one, value) for one in [*known[key], *others]):
                    names = [one if isinstance(one, str) else shown(one) for one in known[key]]
                    raise InputError(
                        f"{matrix.path}: leave_out[{i}].{key}: found {shown(value)}, which matches nothing; expected "
                        f"one of {', '.join(names)}{did_you_mean(value, names)}"
                    )


def _chosen(matrix: MatrixFile, recording: str) -> bool:
    return any(fnmatchcase(recording, pattern) for pattern in matrix.matrix.recordings)


def _matches(value: Any, wanted: Any) -> bool:
    if isinstance(wanted, list):
        return any(_matches(value, w) for w in wanted)
    return fnmatchcase(value, wanted) if isinstance(value, str) and isinstance(wanted, str) else bool(value == wanted)
