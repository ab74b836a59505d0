"""`run --missing-effort`: the room that works it out, and the traces of the result folder, meet here."""

from collections.abc import Sequence
from pathlib import Path

from realitygap_engines import RealityGapError

from realitygap.compare.comparison import cell_of, motions_of
from realitygap.compare.row import slug
from realitygap.compare.traces import FOLDER, add_traces
from realitygap.files.progress import Progress
from realitygap.missing.effort import MissingEffort, missing_of
from realitygap.missing.files import NAME, as_trace, viewed, write_told
from realitygap.missing.library import Missing
from realitygap.scenario.file import ScenarioFile


def add_missing(folder: Path, file: ScenarioFile, engines: Sequence[str], progress: Progress) -> list[str]:
    """Put the missing effort of every recording into the traces of its cells, and say what it depends on.

    Returns the sentences; what it depends on is told of the first engine that can tell it.
    """
    motions, said, told = motions_of(file), list[str](), False
    with progress.task("missing effort", len(engines) * len(motions)) as advance:
        for engine in engines:
            found: list[MissingEffort] = []
            for motion in motions:
                advance(f"{engine}: {motion.name}")
                try:
                    runs = [missing_of(e, engine) for e in motion.experiments]
                except RealityGapError as error:
                    said.append(f"missing effort: not told, {error}")
                    continue
                found += runs
                path = folder / FOLDER / f"{slug(cell_of(motion, engine))}.parquet"
                if path.is_file():
                    alone = len(runs) == 1
                    shown = [viewed(r, "missing_effort" if alone else f"missing_effort/{r.name}") for r in runs]
                    whole = {f"{NAME}{r.name}": as_trace(r) for r in runs}
                    add_traces(path, whole, {name: t for one in shown for name, t in one.items()})
            if found and not told:
                missing = Missing(file.scenario.name, tuple(found))
                write_told(folder, engine, [missing.shape(j) for j in found[0].joints])
                said, told = [*said, *missing.sentences], True
    return list(dict.fromkeys(said))
