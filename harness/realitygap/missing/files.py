"""The missing effort in the files of a result folder: as traces, and what it depends on as JSON and as effects."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import yaml

from realitygap.files.whole import write_whole
from realitygap.missing.effort import MissingEffort, variables_of
from realitygap.missing.shape import Shape
from realitygap.missing.words import sentence
from realitygap.trace.trace import Trace

NAME = "missing effort of "
"""How the traces of a missing effort are called, before the recording's name."""
TOLD = "missing_effort.json"
ADDED = "missing_effort.yaml"
UNKNOWN = "no simulation knows the temperature of a motor: what depends on it at {} is no effect below"


def as_trace(missing: MissingEffort) -> Trace:
    """The missing effort as the effort of a trace, beside the smoothed motion, the load, the supply and the
    temperature.
    """
    v = missing.variables
    return Trace(
        missing.time,
        missing.joints,
        position=v["angle"],
        velocity=v["speed"],
        effort=missing.effort,
        command=v["angle"] + v["error"] if "error" in v else None,
        supply=v["supply"][:, 0] if "supply" in v else None,
        effort_error=missing.error,
        load=v["load"],
        temperature=v.get("temperature"),
    )


def of_trace(name: str, engine: str, trace: Trace, slides: Sequence[str]) -> MissingEffort:
    """The missing effort that `as_trace` made a trace of; `slides` names the prismatic joints."""
    assert trace.position is not None
    assert trace.velocity is not None
    assert trace.effort is not None
    assert trace.effort_error is not None
    assert trace.load is not None
    return MissingEffort(
        name=name.removeprefix(NAME),
        engine=engine,
        use=None,
        joints=trace.joints,
        slides=tuple(j in slides for j in trace.joints),
        time=trace.time,
        effort=trace.effort,
        error=trace.effort_error,
        variables=variables_of(
            trace.time, trace.position, trace.velocity, trace.load, trace.command, trace.supply, trace.temperature
        ),
    )


def viewed(missing: MissingEffort, name: str) -> dict[str, Trace]:
    """Traces for viewers that know no bands: the missing effort, and both ends of its band."""
    low, high = missing.band
    whole = as_trace(missing)
    ends = {end: Trace(missing.time, missing.joints, position=whole.position, velocity=whole.velocity, effort=effort)
            for end, effort in (("low", low), ("high", high))}  # fmt: skip
    return {name: whole, f"{name}/low": ends["low"], f"{name}/high": ends["high"]}


def write_told(folder: Path, engine: str, shapes: Sequence[Shape]) -> None:
    """Write `missing_effort.json`, and `missing_effort.yaml`: the effects that a scenario can take over."""
    content = {"schema": 1, "engine": engine, "joints": [_told(shape) for shape in shapes]}
    write_whole(folder / TOLD, json.dumps(content, indent=1, ensure_ascii=False) + "\n")
    lines = ["# What the missing effort of every joint depends on, as effects of a scenario; no law, and no cause.\n"]
    lines += [f"# {sentence(shape)}\n" for shape in shapes]
    lines += [f"# {UNKNOWN.format(shape.joint)}\n" for shape in shapes if len(shape.effects) < len(shape.terms)]
    effects = [{"effect": e.effect, "target": e.target, **e.parameters} for shape in shapes for e in shape.effects]
    lines.append(yaml.safe_dump({"effects": effects}, sort_keys=False, default_flow_style=None, width=118))
    write_whole(folder / ADDED, "".join(lines))


def read_told(folder: Path) -> list[dict[str, Any]]:
    """What `write_told` wrote of every joint; nothing where it did not."""
    path = folder / TOLD
    if not path.is_file():
        return []
    found: list[dict[str, Any]] = json.loads(path.read_text(encoding="utf-8"))["joints"]
    return found


def _told(shape: Shape) -> dict[str, Any]:
    return {
        "joint": shape.joint,
        "unit": shape.unit,
        "rms": shape.size,
        "mean": shape.mean,
        "share": shape.share,
        "noise": shape.noise,
        "within": shape.within,
        "sentence": sentence(shape),
        "terms": [
            {
                "variables": list(term.variables),
                "share": term.share,
                "periods": term.periods,
                "knots": [list(k) for k in term.knots],
                "values": list(term.values),
            }
            for term in shape.terms
        ],
        "as_well_by": [list(r) for r in shape.rivals],
    }
