"""Tables of another shape than a column for every joint's signal: what they are, and how they become such."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd

from realitygap.recording.readers.cells import Frame

LOOKED_AT = 1000
"""Rows in which joints are looked for."""


def told_shape(frame: Frame, joints: Sequence[str], time: Sequence[str]) -> str:
    """The end of a sentence on a table in which no column is one joint's, where it shows why; "" where it does not."""
    for name in frame.columns:
        cells = frame[name].iloc[:LOOKED_AT].dropna()
        if len(cells) and set(joints) <= set(cells[cells.map(lambda cell: isinstance(cell, str))]):
            return (
                f"; {name} names the joints, row by row: make a column of each joint's signals, as pandas' "
                f"`frame.pivot(index={time[0]!r}, columns={name!r})` does"
            )
        if len(cells) and all(_holds_several(cell) for cell in cells.iloc[:3]):
            return f"; {name} holds several numbers in every cell: make a column of each, as {name}_{joints[0]}"
    return ""


def _holds_several(cell: Any) -> bool:
    """Whether a cell holds a list: as one, or as its text, in brackets or as numbers beside one another."""
    if isinstance(cell, str):
        inner = cell.strip().strip("[](){}").replace(",", " ").replace(";", " ").split()
        return len(inner) > 1 and bool(pd.to_numeric(pd.Series(inner), errors="coerce").notna().all())
    return isinstance(cell, list | tuple | np.ndarray) and np.size(cell) > 1
