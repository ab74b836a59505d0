"""A scenario under the values of a matrix's axes; a value that it cannot have is told at the axis, not at the key."""

import re
from collections.abc import Mapping
from typing import Any

from realitygap.files.errors import InputError
from realitygap.files.found import shown
from realitygap.matrix.matrix_file import NAMED_AXES, MatrixFile
from realitygap.scenario.file import ScenarioFile

KEY = re.compile(r"\S+: (?=found )")
"""The scenario's key before what was found there; the axis says it already."""


def variant_of(matrix: MatrixFile, file: ScenarioFile, axes: Mapping[str, Any]) -> tuple[str, ScenarioFile]:
    """The revision's name, and the scenario under a combination of axis values.

    Raises:
        InputError: for a revision that the scenario does not have, a key that its recordings set themselves, and a key
            or value that it cannot have.
    """
    changes = _changes(matrix, file, axes)
    try:
        return str(axes.get("revision", "")), file.override(changes)
    except InputError as error:
        raise InputError(f"{matrix.path}: {_blamed(matrix, file, axes, changes, str(error))}") from None


def _blamed(
    matrix: MatrixFile, file: ScenarioFile, axes: Mapping[str, Any], changes: Mapping[str, Any], sentence: str
) -> str:
    """The sentence at the axis that alone makes it, or else with all values, that only together are wrong."""
    said = sentence.removeprefix(f"{file.path}: ")
    for (axis, value), (key, change) in zip(axes.items(), changes.items(), strict=True):
        try:
            file.override({key: change})
        except InputError as alone:
            if str(alone) == sentence:
                number = matrix.matrix.axes[axis].index(value)
                return f"axes.{axis}[{number}]: {KEY.sub('', said, count=1)}" if KEY.match(said) else f"axes: {said}"
    together = ", ".join(f"{axis} {shown(value)}" for axis, value in axes.items())
    return f"axes: {together}: {said}"


def _changes(matrix: MatrixFile, file: ScenarioFile, axes: Mapping[str, Any]) -> dict[str, Any]:
    """The scenario keys that a combination of axis values changes, in the order of the axes."""
    changes = {}
    for axis, value in axes.items():
        if axis == "revision":
            known = file.scenario.revisions
            if value not in known:
                raise InputError(
                    f"{matrix.path}: axes.revision: found {value}; {file.path} has under revisions: "
                    f"{', '.join(known) or 'none'}"
                )
            value = known[value]
        changes[NAMED_AXES.get(axis, axis)] = value
    recordings = file.scenario.recordings
    for i, run in enumerate(recordings.runs if recordings else []):
        for key in changes:
            if key in run.overrides:
                raise InputError(
                    f"{matrix.path}: axes: {key} is set by recordings.runs[{i}].with of {file.path}, which holds for "
                    "that recording; expected an axis that the recordings leave open"
                )
    return changes
