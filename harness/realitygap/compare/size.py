"""How large the traces of a motion are, and how thin they are kept where that is too much."""

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import numpy as np

from realitygap.compare.comparison import WHOLE, RepeatedMotion, whole_size
from realitygap.files.mapped import let_go
from realitygap.trace.trace import Array, Trace

THIN = 5e7
"""Bytes of numbers of a cell that is thinned: more than any viewer shows."""


def told(motions: Iterable[RepeatedMotion], *, whole: bool) -> str | None:
    """A sentence on the traces of cells that are large, one motion for each; None where none is."""
    large = [size for m in motions if (size := whole_size(m)) > WHOLE]
    if not large:
        return None
    cells = f"{len(large)} cell{'s' * (len(large) > 1)}"
    if whole:
        return f"the whole traces of {cells} are {sum(large) / 1e9:.1f} GB of numbers, in memory and, packed, on disk"
    return (
        f"the traces of {cells} are thinned; whole they would be {sum(large) / 1e9:.1f} GB of numbers "
        "(`run --whole-traces`, in a matrix `traces: whole`); all gaps are of every sample"
    )


def thinned(traces: dict[str, Trace]) -> dict[str, Trace]:
    """Every so many samples of traces, all alike, so that they are not larger than `THIN`."""
    every = int(np.ceil(sum(map(_bytes, traces.values())) / THIN))
    return traces if every <= 1 else {name: _thinner(trace, every) for name, trace in traces.items()}


def _thinner(trace: Trace, every: int) -> Trace:
    """One of so many samples; of signals that lie in files, one is in memory at a time."""
    kept: dict[str, Any] = {}
    for signal in Trace.SIGNALS:
        value = getattr(trace, signal)
        kept[signal] = None if value is None else value[::every].copy()
        let_go(value)
    return replace(trace, time=trace.time[::every].copy(), **kept)


def _bytes(trace: Trace) -> int:
    values: list[Array | None] = [getattr(trace, signal) for signal in Trace.SIGNALS]
    return trace.time.nbytes + sum(v.nbytes for v in values if v is not None)
