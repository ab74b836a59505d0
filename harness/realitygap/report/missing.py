"""The missing effort on the page: a sentence and a picture of every joint, from the traces of a result folder."""

from dataclasses import dataclass
from pathlib import Path

from realitygap.missing.effort import MissingEffort
from realitygap.missing.files import NAME, of_trace, read_told
from realitygap.report.folder import Results
from realitygap.trace.parquet import read_about, read_parquet

MOST = 12
"""Joints that get a picture: those with the largest missing efforts for what they carry."""


@dataclass(frozen=True)
class Picture:
    """What is told of one joint: a sentence, and the figure's file; None for one joint too many."""

    sentence: str
    path: Path | None


def missing_pictures(results: Results, out: Path) -> list[Picture]:
    """Write `figures/missing-effort-JOINT.svg` of every joint into a folder, and tell what they show; nothing without
    any.
    """
    told = read_told(results.folder)
    runs = _runs(results) if told else []
    if not runs:
        return [Picture(one["sentence"], None) for one in told]
    from realitygap.report.draw_missing import draw_missing  # matplotlib, which few pages need here

    order = sorted(told, key=lambda one: -one["rms"] * (1 - min(one["noise"], 1.0)))
    pictures = []
    for one in told:
        path = None
        if any(one is chosen for chosen in order[:MOST]):
            safe = "".join(c if c.isalnum() or c in "-_." else "-" for c in one["joint"])
            path = draw_missing(out / "figures" / f"missing-effort-{safe}.svg", runs, one)
        pictures.append(Picture(one["sentence"], path))
    return pictures


def _runs(results: Results) -> list[MissingEffort]:
    """The missing effort of every recording, in the first engine that has it."""
    by_engine: dict[str, list[MissingEffort]] = {}
    for path in results.traces.values():
        about = read_about(path)
        engine, slides = str(about["cell"]["engine"]), about["slides"]
        names = [name for name in about["traces"] if name.startswith(NAME)]
        found = read_parquet(path, only=names) if names else {}
        by_engine.setdefault(engine, []).extend(of_trace(n, engine, t, slides) for n, t in found.items())
    return next((runs for engine in results.engines if (runs := by_engine.get(engine))), [])
