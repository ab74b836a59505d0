"""`manifest.json`: where the numbers of a result folder come from."""

import hashlib
import json
import os
import platform
import sys
from collections.abc import Iterable, Mapping, Sequence
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import realitygap_engines as engines

from realitygap.compare.comparison import RepeatedMotion
from realitygap.compare.row import Cell, slug
from realitygap.files.whole import write_whole
from realitygap.scenario.file import ScenarioFile

PACKAGES = ("realitygap", "numpy", "scipy", "numba", "pydantic", "rosbags", "yourdfpy")


PART = 1 << 20
"""Bytes of a file that are read at a time: recordings are long."""


def write_manifest(
    out: Path,
    name: str,
    motions: Iterable[tuple[ScenarioFile, RepeatedMotion]],
    settings: Sequence[tuple[Cell, Mapping[str, Any]]],
    failures: Mapping[str, str],
    traces: Iterable[str],
    warnings: Sequence[str] = (),
    thinned: str | None = None,
) -> None:
    """Write versions, what each adapter really set, hashes of the inputs, the command line and notes.

    Args:
        out: the result folder.
        name: of the scenario or the matrix.
        motions: what was simulated.
        settings: of every cell that ran.
        failures: what became of the cells that did not, by their slug.
        traces: names of the MCAP files below the folder; the Parquet files lie beside them.
        warnings: sentences on likely mistakes in the scenarios.
        thinned: a sentence on traces that are not whole.
    """
    sources: set[Path] = set()
    notes: dict[str, list[str]] = {"likely mistakes": list(warnings)} if warnings else {}
    if thinned:
        notes["traces"] = [thinned]
    virtual = False
    for file, motion in motions:
        virtual |= file.scenario.virtual
        for e in motion.experiments:
            sources |= {file.path, file.resolve(e.scenario.robot.urdf, "robot.urdf")}
            if e.scenario.motion is not None and e.scenario.motion.keyframes is not None:
                sources.add(file.resolve(e.scenario.motion.keyframes, "motion.keyframes"))
            notes.setdefault("model", list(e.plant.model.notes))
            if e.recording is not None:
                sources |= set(e.recording.files or (e.recording.path,))
                notes[f"recording {e.name}"] = [*e.recording.notes, *e.notes]
    used = {cell.engine: cell.engine_version for cell, _ in settings}
    manifest = {
        "schema": 1,
        "scenario": name,
        "command_line": sys.argv[1:],
        "python": platform.python_version(),
        "platform": platform.machine(),
        "versions": {p: _version(p) for p in PACKAGES} | dict(sorted(used.items())),
        "settings": _settings(settings),
        "capabilities": {
            engine: {k: {"level": v.level, "how": v.how} for k, v in engines.load(engine).capabilities().items()}
            for engine in sorted(used)
        },
        "inputs": dict(sorted((_portable(path), digest(path)) for path in sources)),
        "notes": notes,
        "virtual": virtual,
        "failures": dict(sorted(failures.items())),
        "traces": {Path(t).stem: t for t in sorted(traces)},
    }
    write_whole(out / "manifest.json", json.dumps(manifest, indent=1, default=str, ensure_ascii=False) + "\n")


def _settings(settings: Sequence[tuple[Cell, Mapping[str, Any]]]) -> dict[str, dict[str, Any]]:
    """Per engine what its cells have set; a setting that differs between cells is the list of its values."""
    found: dict[str, dict[str, list[Any]]] = {}
    for cell, values in sorted(settings, key=lambda pair: slug(pair[0])):
        for key, value in values.items():
            seen = found.setdefault(cell.engine, {}).setdefault(key, [])
            if value not in seen:
                seen.append(value)
    return {
        engine: {k: v[0] if len(v) == 1 else sorted(v, key=lambda x: (str(type(x)), x)) for k, v in keys.items()}
        for engine, keys in sorted(found.items())
    }


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None


def digest(path: Path) -> str:
    """SHA-256 of a file, or of all files of a folder with their names."""
    out = hashlib.sha256()
    for file in sorted(path.rglob("*")) if path.is_dir() else [path]:
        if file.is_file():
            out.update(file.name.encode())
            with file.open("rb") as opened:
                while part := opened.read(PART):
                    out.update(part)
    return out.hexdigest()


def _portable(path: Path) -> str:
    """A path that means the same elsewhere, where there is one: below ${REALITYGAP_DATA} or below where we are."""
    whole = path.resolve()
    data = os.environ.get("REALITYGAP_DATA")
    roots = [("${REALITYGAP_DATA}/", Path(data).resolve())] if data else []
    for prefix, root in [*roots, ("", Path.cwd())]:
        if whole.is_relative_to(root):
            return prefix + whole.relative_to(root).as_posix()
    return str(whole)
