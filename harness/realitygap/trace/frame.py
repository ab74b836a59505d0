"""A trace as a table: one row per sample, one column per signal and joint."""

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

if TYPE_CHECKING:
    from realitygap.trace.trace import Trace

OF_JOINTS = ("position", "velocity", "effort", "command", "effort_error", "load", "temperature")
AXES = {1: ("",), 3: ("x", "y", "z"), 4: ("w", "x", "y", "z")}
"""The second name of the columns of a signal that belongs to no joint, by how many it has."""


def to_frame(trace: "Trace") -> pd.DataFrame:
    """The trace as a table; see `Trace.to_frame`."""
    names: list[tuple[str, str]] = []
    blocks = [np.empty((len(trace.time), 0))]
    for signal in trace.SIGNALS:
        value = getattr(trace, signal)
        if value is not None:
            block = value if value.ndim == 2 else value[:, None]
            names += [(signal, name) for name in (trace.joints if signal in OF_JOINTS else AXES[block.shape[1]])]
            blocks.append(block)
    return pd.DataFrame(
        np.hstack(blocks),
        index=pd.Index(trace.time, name="time"),
        columns=pd.MultiIndex.from_tuples(names, names=["signal", "joint"]),
    )
