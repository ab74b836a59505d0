"""Recordings that repeat one motion: they are averaged, which is told, and one that is another's copy is left out."""

from collections.abc import Sequence
from dataclasses import replace

from realitygap.init.sections import Sections
from realitygap.recording.align import RecordedRun, group_repetitions

SAME = "they count as recorded under the same conditions; `with` at a run says what differs, as a gain or a load"
SHOWN = 4
"""Names that a sentence lists."""


def without_copies(sections: Sections, runs: Sequence[RecordedRun]) -> tuple[Sections, list[RecordedRun], list[str]]:
    """The sections and runs of a draft without those that hold the same measurement as one before, and what is told of
    each: two copies are no repetitions, and a comparison refuses them. `runs` are in the order of the draft.
    """
    kept: list[int] = []
    told = []
    for i, run in enumerate(runs):
        first = next((k for k in kept if runs[k].recording.trace.same_as(run.recording.trace)), None)
        if first is None:
            kept.append(i)
        else:
            here, there = run.recording.place, runs[first].recording.place
            told.append(f"{here}: holds the same measurement as {there}, and is left out of the runs")
    if not told:
        return sections, list(runs), []
    return replace(sections, runs=[sections.runs[i] for i in kept]), [runs[i] for i in kept], told


def repeated(runs: Sequence[RecordedRun]) -> list[str]:
    """A sentence for the repetitions of every motion among the runs of a draft."""
    out = []
    for group in group_repetitions(runs):
        names = [runs[i].name for i in group.indices]
        if len(names) > 1:
            listed = ", ".join(names[:SHOWN]) + (f" and {len(names) - SHOWN} more" if len(names) > SHOWN else "")
            out.append(f"taken as repetitions of one motion and averaged: {listed}")
    return [f"{line}: {SAME}" if not k else line for k, line in enumerate(out)]
