"""The mistakes of a matrix, told before the long work: its scenarios', and those that a value of an axis makes."""

from collections.abc import Callable, Iterator
from typing import Any

from realitygap.check import certain
from realitygap.check.mistake import Mistake
from realitygap.files.errors import InputError
from realitygap.matrix.matrix_file import NAMED_AXES, MatrixFile
from realitygap.matrix.plan import Reader
from realitygap.matrix.variant import variant_of
from realitygap.scenario.file import ScenarioFile

UNSEEN = ("physics.step_rate", "physics.solver_iterations", "ground")
"""Keys that concern the simulation alone: no mistake of a recording or a robot depends on them."""


def checked(matrix: MatrixFile, say: Callable[[str], None] = lambda _: None, read: Reader | None = None) -> list[str]:
    """Likely mistakes in the scenarios of a matrix under the values of its axes.

    Every value is checked once, beside the first values of the other axes. `read` reads the recordings.

    Raises:
        InputError: for a certain mistake, with the axis and the value that make it; for an engine that is not there.
    """
    matrix.engine_names()
    out: list[str] = []
    read = read or Reader()
    for file in matrix.scenarios:
        known = set[tuple[str, tuple[str, ...]]]()
        where = f"{file.scenario.name}: " if len(matrix.scenarios) > 1 else ""
        for number, (axis, axes) in enumerate(_alone(matrix)):
            at = f"{axis} {axes[axis]}: " if number else ""
            for m in _found(matrix, file, axis, axes, read):
                if (m.kind, m.joints) not in known:
                    known.add((m.kind, m.joints))
                    out.append(f"{where}{at}{m.text}")
                    say(f"likely a mistake: {out[-1]}")
    return out


def _alone(matrix: MatrixFile) -> Iterator[tuple[str, dict[str, Any]]]:
    """The first values of all axes, then every other value of one axis beside them: the axis (of the first: the only
    one, if any), and all values.
    """
    first = {axis: values[0] for axis, values in matrix.matrix.axes.items()}
    yield next(iter(first)) if len(first) == 1 else "", first
    for axis, values in matrix.matrix.axes.items():
        for value in values[1:]:
            yield axis, {**first, axis: value}


def _found(matrix: MatrixFile, file: ScenarioFile, axis: str, axes: dict[str, Any], read: Reader) -> list[Mistake]:
    """The likely mistakes under some values; a certain one is told with the axis that makes it."""
    _, variant = variant_of(matrix, file, axes)
    try:
        _check_time(matrix, variant)
        unseen = NAMED_AXES.get(axis, axis) in UNSEEN and axes[axis] != matrix.matrix.axes[axis][0]
        return [] if unseen else certain(variant, read)
    except InputError as error:
        if not axis or str(error).startswith(str(matrix.path)):
            raise
        raise InputError(f"{matrix.path}: axes.{axis}: {axes[axis]}: {error}") from None


def _check_time(matrix: MatrixFile, variant: ScenarioFile) -> None:
    for axis in matrix.matrix.axes:
        if variant.scenario.follows and NAMED_AXES.get(axis, axis) in UNSEEN[:2]:
            raise InputError(
                f"{matrix.path}: axes.{axis}: changes nothing in {variant.scenario.name}, whose motion is followed and "
                "not integrated over time; expected other axes, or a scenario with servos"
            )
