"""Recordings that a comparison averages, as repetitions of one motion: told when a scenario is drafted."""

from collections.abc import Mapping
from pathlib import Path

from realitygap.recording import Recording
from realitygap.recording.align import RecordedRun, group_repetitions
from realitygap.scenario.file import ScenarioFile

SAME = "they count as recorded under the same conditions; `with` at a run says what differs, as a gain or a load"
SHOWN = 4
"""Names that a sentence lists."""


def repeated(file: ScenarioFile, recordings: Mapping[Path, Recording]) -> list[str]:
    """A sentence for the repetitions of every motion. `recordings` are those of the draft, by path."""
    runs = [RecordedRun(case.name, recordings[case.path]) for case in file.cases()]
    out = []
    for group in group_repetitions(runs):
        names = [runs[i].name for i in group.indices]
        if len(names) > 1:
            listed = ", ".join(names[:SHOWN]) + (f" and {len(names) - SHOWN} more" if len(names) > SHOWN else "")
            out.append(f"taken as repetitions of one motion and averaged: {listed}")
    return [f"{line}: {SAME}" if not k else line for k, line in enumerate(out)]
