"""Joint states that `rostopic echo -p` wrote as a table: arrays as numbered columns, of which one holds the names."""

import re

import numpy as np
import pandas as pd

from realitygap.recording.readers.messages import SIGNALS

NAME = re.compile(
    r"(?P<before>(?:.*[^A-Za-z_])?)(?P<field>name|names|joint_names)(?P<mark>[^A-Za-z0-9]?)(?P<number>\d+)(?P<after>\]?)"
)
"""The column of one element of the names: `field.name0`, or as others write arrays, `name_0` and `name[0]`."""
CALLED = {field: signal for signal, fields in SIGNALS.items() for field in fields}


def by_joint(frame: pd.DataFrame) -> pd.DataFrame:
    """A table with a column for every joint, as `position/elbow`, in the place of numbered ones whose joints the values
    of other columns name, row by row; other tables as they are. Every array of as many elements is taken for one of
    joints: those of a controller's state become `actual.positions/elbow`.
    """
    found = {label: match for label in frame.columns if (match := NAME.fullmatch(label))}
    names = {
        match["number"]: (label, match)
        for label, match in found.items()
        if frame[label].map(lambda cell: isinstance(cell, str)).any()
    }
    if not names:
        return frame
    columns = {number: frame[label] for number, (label, _) in names.items()}
    joints = list(dict.fromkeys(name for column in columns.values() for name in column.dropna().unique()))
    where = {joint: {number: (column == joint).to_numpy() for number, column in columns.items()} for joint in joints}
    arrays = _arrays(frame, *next(iter(names.values())), set(names))
    if not arrays:
        return frame
    out = {}
    for field, values in arrays.items():
        for joint in joints:
            whole = next((number for number, rows in where[joint].items() if rows.all()), None)
            if whole is not None:
                out[f"{CALLED.get(field, field)}/{joint}"] = frame[values[whole]]
                continue
            gathered = np.full(len(frame), np.nan, dtype=object)
            for number, rows in where[joint].items():
                gathered[rows] = frame[values[number]].to_numpy()[rows]
            out[f"{CALLED.get(field, field)}/{joint}"] = pd.Series(gathered, index=frame.index).infer_objects()
    spare = [label for label, _ in names.values()] + [label for values in arrays.values() for label in values.values()]
    return frame.drop(columns=spare).assign(**out)


def _arrays(frame: pd.DataFrame, label: str, name: "re.Match[str]", numbers: set[str]) -> dict[str, dict[str, str]]:
    """The columns by number of every field beside a name that has as many elements as there are names."""
    mark, after = re.escape(name["mark"]), re.escape(name["after"])
    form = re.compile(rf"{re.escape(name['before'])}(?P<field>.*[A-Za-z]){mark}(?P<number>\d+){after}")
    fields: dict[str, dict[str, str]] = {}
    for other in frame.columns:
        if other != label and (match := form.fullmatch(other)) and match["field"] != name["field"]:
            fields.setdefault(match["field"], {})[match["number"]] = other
    return {field: labels for field, labels in fields.items() if set(labels) == numbers}
