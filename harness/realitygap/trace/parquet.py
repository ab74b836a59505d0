"""Traces kept whole: every sample and signal as Parquet, which pandas, Polars, DuckDB and pyarrow open.

One file holds several traces, each on its own clock, one below the other: the column `trace` names them. The other
columns are `time` [s], `supply` [V] and one per signal and joint or axis, as `position/elbow`, with the unit in the
column's metadata. A signal that a trace does not have is null in its rows; a sample that is missing is NaN.
"""

import io
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from realitygap.files.whole import write_whole
from realitygap.trace.trace import Array, Trace

ABOUT = b"realitygap"
"""The key of the file's metadata under which JSON says what the traces are of."""
JOINT_SIGNALS = ("position", "velocity", "effort", "command", "effort_error", "load", "temperature")
AXES = {3: ("x", "y", "z"), 4: ("w", "x", "y", "z")}
UNITS = {
    "position": ("rad", "m"),
    "velocity": ("rad/s", "m/s"),
    "effort": ("N·m", "N"),
    "effort_error": ("N·m", "N"),
    "load": ("N·m", "N"),
    "base_position": ("m", "m"),
    "base_linear": ("m/s", "m/s"),
    "base_angular": ("rad/s", "rad/s"),
    "imu_angular": ("rad/s", "rad/s"),
    "supply": ("V", "V"),
    "temperature": ("°C", "°C"),
}
"""Of a signal, of a hinge or the body, and of a slide; a command's depends on the servo and is not told."""


def write_parquet(
    path: Path, traces: Mapping[str, Trace], about: Mapping[str, Any] | None = None, slides: Sequence[str] = ()
) -> None:
    """Write traces into one file, whole or not at all: the same traces are the same bytes.

    Args:
        path: the file.
        traces: the traces by name.
        about: what they are of, for `read_about`; anything that JSON can say.
        slides: the prismatic joints, for the units.
    """
    columns = {name: _columns(trace) for name, trace in traces.items()}
    names = list(dict.fromkeys(c for found in columns.values() for c in found))
    content = {"traces": {name: _shape(trace) for name, trace in traces.items()}, "slides": list(slides)}
    fields = [pa.field("trace", pa.string()), pa.field("time", pa.float64(), metadata={"unit": "s"})]
    fields += [pa.field(c, pa.float64(), metadata=_unit(c, slides)) for c in names]
    schema = pa.schema(fields, metadata={ABOUT: json.dumps({**(about or {}), **content}, ensure_ascii=False)})
    out = io.BytesIO()
    with pq.ParquetWriter(
        out,
        schema,
        compression="zstd",
        use_dictionary=["trace"],
        use_byte_stream_split=[f.name for f in fields[1:]],  # bytes of like weight lie together and pack well
        write_statistics=False,
        write_page_checksum=True,
    ) as writer:
        for name, trace in traces.items():
            size = len(trace.time)
            absent = pa.nulls(size, pa.float64())
            values = [columns[name].get(c, absent) for c in names]
            table = pa.table([pa.array([name] * size, pa.string()), pa.array(trace.time), *values], schema=schema)
            writer.write_table(table, row_group_size=max(size, 1))  # a row group per trace
    write_whole(path, out.getvalue())


def read_parquet(
    path: Path, only: Sequence[str] | None = None, signals: Sequence[str] = Trace.SIGNALS
) -> dict[str, Trace]:
    """The traces of a file that `write_parquet` wrote, by name, as they were.

    Args:
        path: the file.
        only: names of the traces to read; those that the file does not hold are left out.
        signals: those to read; the others are None.
    """
    with pq.ParquetFile(path, page_checksum_verification=True) as file:
        shapes = json.loads(file.schema_arrow.metadata[ABOUT])["traces"]
        chosen = {n: i for i, n in enumerate(shapes) if only is None or n in only}
        names = [n for n in file.schema_arrow.names if n == "time" or n.partition("/")[0] in signals]
        return {n: _trace(file.read_row_group(i, columns=names), shapes[n], signals) for n, i in chosen.items()}


def read_about(path: Path) -> dict[str, Any]:
    """What the traces of a file are of; the traces themselves are not read."""
    found: dict[str, Any] = json.loads(pq.read_schema(path).metadata[ABOUT])
    return found


def _shape(trace: Trace) -> dict[str, Any]:
    present = [s for s in Trace.SIGNALS if getattr(trace, s) is not None]
    return {"joints": list(trace.joints), "signals": present, "notes": list(trace.notes)}


def _columns(trace: Trace) -> dict[str, Array]:
    out: dict[str, Array] = {}
    for signal in Trace.SIGNALS:
        values = getattr(trace, signal)
        if values is None:
            continue
        if values.ndim == 1:
            out[signal] = values
            continue
        parts = _parts(signal, trace.joints)
        out |= {f"{signal}/{part}": np.ascontiguousarray(values[:, i]) for i, part in enumerate(parts)}
    return out


def _parts(signal: str, joints: Sequence[str]) -> Sequence[str]:
    if signal in JOINT_SIGNALS:
        return joints
    return AXES[4 if signal.endswith("quaternion") else 3]


def _unit(column: str, slides: Sequence[str]) -> dict[str, str] | None:
    signal, _, part = column.partition("/")
    return {"unit": UNITS[signal][signal in JOINT_SIGNALS and part in slides]} if signal in UNITS else None


def _trace(table: pa.Table, shape: Mapping[str, Any], wanted: Sequence[str]) -> Trace:
    joints = tuple(shape["joints"])
    signals: dict[str, Array] = {}
    for signal in (s for s in shape["signals"] if s in wanted):
        if signal == "supply":
            signals[signal] = table[signal].to_numpy()
            continue
        columns = [table[f"{signal}/{part}"].to_numpy() for part in _parts(signal, joints)]
        signals[signal] = np.column_stack(columns) if columns else np.empty((table.num_rows, 0))
    return Trace(table["time"].to_numpy(), joints, notes=tuple(shape["notes"]), **signals)
