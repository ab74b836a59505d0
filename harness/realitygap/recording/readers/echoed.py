"""Joint states that `rostopic echo -p` wrote as a table: arrays as numbered columns, of which one holds the names."""

import re

import numpy as np
import pandas as pd

from realitygap.recording.readers.messages import SIGNALS

NAME = re.compile(r"(?P<before>(?:.*[^A-Za-z])?)name(?P<mark>[^A-Za-z0-9]?)(?P<number>\d+)(?P<after>\]?)")
"""The column of one element of the names: `field.name0`, or as others write arrays, `name_0` and `name[0]`."""


def by_joint(frame: pd.DataFrame) -> pd.DataFrame:
    """A table with a column for every joint, as `position/elbow`, in the place of numbered ones whose joints the values
    of other columns name, row by row; other tables as they are.
    """
    found = {label: match for label in frame.columns if (match := NAME.fullmatch(label))}
    names = {label: frame[label] for label in found if frame[label].map(lambda cell: isinstance(cell, str)).any()}
    if not names:
        return frame
    joints = list(dict.fromkeys(name for column in names.values() for name in column.dropna().unique()))
    out = {}
    for signal, fields in SIGNALS.items():
        values = {label: value for label in names if (value := _beside(frame, found[label], fields)) is not None}
        if len(values) < len(names):
            continue
        for joint in joints:
            where = {label: (column == joint).to_numpy() for label, column in names.items()}
            own = next((label for label, rows in where.items() if rows.all()), None)
            if own is not None:
                out[f"{signal}/{joint}"] = frame[values[own]]
                continue
            gathered = np.full(len(frame), np.nan, dtype=object)
            for label, rows in where.items():
                gathered[rows] = frame[values[label]].to_numpy()[rows]
            out[f"{signal}/{joint}"] = pd.Series(gathered, index=frame.index).infer_objects()
        frame = frame.drop(columns=list(values.values()))
    if not out:
        return frame
    return frame.drop(columns=list(names)).assign(**out)


def _beside(frame: pd.DataFrame, name: "re.Match[str]", fields: tuple[str, ...]) -> str | None:
    """The column of the value that belongs to a name."""
    labels = (f"{name['before']}{field}{name['mark']}{name['number']}{name['after']}" for field in fields)
    return next((label for label in labels if label in frame), None)
