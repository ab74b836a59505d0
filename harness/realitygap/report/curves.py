"""The curves of a cell for the page: thinned, in people's units, small enough to travel with it.

They are made from the whole traces. `curves/<cell>.js` calls `realitygap.curves(name, {...})`. It is JSON in a function
call, because a page opened from a disk may load a script that lies beside it but may not fetch a file. What was
measured is the same for every engine, so it is written once, as `curves/measured-<hash>.js`. Box plots are drawn from
statistics of all samples, not of the thinned ones.
"""

import hashlib
import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from realitygap.compare.gap import JOINT_SIGNALS, Jointed, box, differences, unit_of
from realitygap.compare.row import slug
from realitygap.compare.traces import CellTraces
from realitygap.files.whole import write_whole
from realitygap.recording.frames import angle_between
from realitygap.trace.trace import Array, Trace

SAMPLES = 2000
"""Samples of a curve at most: as a plot of 500 pixels needs that is zoomed in four times."""


def write_curves(folder: Path, traces: CellTraces) -> list[Path]:
    """Write the curves of one cell below a result folder. Returns the files, its own first."""
    simulated, measured = traces.simulated, traces.measured
    clock = thinned(traces, SAMPLES)
    content: dict[str, Any] = {
        "cell": asdict(traces.cell),
        "time": _packed(clock - clock[0]),
        "simulated": _packed_series(simulated.at(clock), traces),
    }
    shared = []
    if measured is not None:
        theirs = json.dumps(_packed_series(measured.at(clock), traces), separators=(",", ":"), ensure_ascii=False)
        content["measured"] = f"measured-{hashlib.sha256(theirs.encode()).hexdigest()[:12]}"
        content["boxes"] = boxes(traces)
        shared = [_write(folder, content["measured"], theirs)]
    text = json.dumps(content, separators=(",", ":"), ensure_ascii=False)
    return [_write(folder, slug(traces.cell), text), *shared]


def thinned(traces: CellTraces, most: int) -> Array:
    """Times [s] at which curves are drawn: the measured ones where something was, evenly thinned. Shape (t,)."""
    clock = (traces.measured or traces.simulated).time
    return clock[:: max(int(np.ceil(clock.size / most)), 1)]


def read_curves(path: Path) -> dict[str, Any]:
    """The content of one file, still packed."""
    text = path.read_text(encoding="utf-8")
    content: dict[str, Any] = json.loads(text[text.index("\n") + 1 : text.rindex(")")])
    return content


def unpack(packed: dict[str, Any]) -> Array:
    """The values of a packed series. Shape (t,); NaN where nothing was measured."""
    values = np.cumsum(np.array(packed["steps"], dtype=np.float64)) * packed["quantum"]
    values[packed.get("missing", [])] = np.nan
    return np.asarray(values)


def _write(folder: Path, name: str, text: str) -> Path:
    path = folder / "curves" / f"{name}.js"
    write_whole(path, f"realitygap.curves({json.dumps(name)},\n{text.replace('<', chr(92) + 'u003c')});\n")
    return path


def _packed(values: Array) -> dict[str, Any]:
    """A series as whole multiples of a quantum, each given as its distance from the one before."""
    finite = np.isfinite(values)
    top = float(np.max(np.abs(values[finite]), initial=0.0))
    quantum = 10.0 ** (int(np.floor(np.log10(top))) - 4) if top > 0 else 1.0
    whole = np.round(np.where(finite, values, 0.0) / quantum).astype(np.int64)
    packed: dict[str, Any] = {"quantum": float(f"{quantum:.0e}"), "steps": np.diff(whole, prepend=0).tolist()}
    if not finite.all():
        packed["missing"] = np.flatnonzero(~finite).tolist()
    return packed


def series(trace: Trace, model: Jointed) -> dict[str, dict[str, tuple[str, Array]]]:
    """Signal -> joint, or axis of the base -> unit and values in it, as people read them. Shapes (t,).

    Of the base: its position along the world's axes, and how far it has turned since the start.
    """
    out: dict[str, dict[str, tuple[str, Array]]] = {}
    for signal in JOINT_SIGNALS:
        values = getattr(trace, signal)
        if values is None:
            continue
        out[signal] = {}
        for joint in model.joints:
            unit, scale = unit_of(signal, joint.prismatic)
            out[signal][joint.name] = unit, values[:, trace.index(joint.name)] * scale
    if trace.base_position is not None:
        columns = zip("xyz", trace.base_position.T, strict=True)
        out["base_position"] = {f"base {axis}": ("m", values) for axis, values in columns}
    if trace.base_quaternion is not None:
        turned = np.rad2deg(angle_between(trace.base_quaternion, trace.base_quaternion[:1]))
        out["base_orientation"] = {"base": ("deg", turned)}
    return out


def _packed_series(trace: Trace, model: Jointed) -> dict[str, dict[str, dict[str, Any]]]:
    found = series(trace, model)
    return {s: {n: {"unit": unit, **_packed(v)} for n, (unit, v) in named.items()} for s, named in found.items()}


def boxes(traces: CellTraces) -> dict[str, dict[str, list[float]]]:
    """Per signal and joint: lower whisker, quartiles, upper whisker (Tukey) and maximum of the absolute difference."""
    out: dict[str, dict[str, list[float]]] = {}
    if traces.boxes is not None or traces.measured is None:
        return traces.boxes or out
    for d in differences(traces, traces.simulated, traces.measured):
        if d.values.size:
            out.setdefault(d.signal, {})[d.joint] = box(d.values)
    return out
