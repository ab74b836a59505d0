"""Which motions are fitted and which are kept to judge on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import product

import numpy as np

from realitygap.compare.comparison import Motion
from realitygap.diagnose.data.case import Case
from realitygap.files.errors import InputError
from realitygap.recording.align import group_repetitions
from realitygap.scenario.file import ScenarioFile
from realitygap.simulate.experiment import Experiment

LEAST = 10
"""Samples that a motion must have to be fitted or judged on."""
FITTED = 0.6
"""The share of a single run that is fitted; the rest is judged on."""


def split(file: ScenarioFile, cases: list[Case], motions: Sequence[Motion]) -> str:
    """Mark every case as `train` or `held_out`; a single run is cut in two. Returns what the user should know of it.

    Args:
        file: the scenario.
        cases: the motions with their noise; the rest of a single run is added.
        motions: the same, with all repetitions.

    Raises:
        InputError: where all runs are held out, the same samples are fitted and judged on, or too few are left.
    """
    said = _mark(file, cases)
    for case in cases:
        if len(case.measured.time) < LEAST:
            raise InputError(
                f"{file.path}: recordings.runs: {case.name} holds {len(case.measured.time)} samples to "
                f"{'judge on' if case.use == 'held_out' else 'fit'}; expected at least {LEAST}"
            )
    runs = [(e, c.use) for c, m in zip(cases, motions, strict=False) for e in m.experiments]
    _check_apart(file, runs)
    return "; ".join([said, *_repeated(runs)] if said else _repeated(runs))


def _mark(file: ScenarioFile, cases: list[Case]) -> str:
    uses = {c.use for c in cases}
    if uses == {"held_out"}:
        raise InputError(
            f"{file.path}: recordings.runs: found use: held_out in every run; expected some to fit (use: train)"
        )
    if "held_out" in uses:
        for c in cases:
            c.use = c.use or "train"
        return ""
    if len(cases) > 1:
        for i, c in enumerate(cases):
            c.use = "held_out" if i % 3 == 2 or (len(cases) == 2 and i == 1) else "train"
        kept = ", ".join(c.name for c in cases if c.use == "held_out")
        return f"no run was marked held_out: every third motion was kept back ({kept})"
    cases[0].use = "train"
    return f"there is one run: {_cut(cases, cases[0])}"


def _cut(cases: list[Case], case: Case) -> str:
    """Keep back the later part of a case, as one more; returns where it was cut, in words."""
    time = case.measured.time
    middle = float(time[0] + FITTED * (time[-1] - time[0]))
    later = replace(case, measured=case.measured.between(middle, np.inf), use="held_out", name=f"{case.name} (rest)")
    case.measured = case.measured.between(-np.inf, middle)
    cases.append(later)
    return f"it was fitted up to {middle:.2f} s and judged on the rest"


def keep_back(cases: list[Case], showing: Sequence[int]) -> str:
    """Cut in two the training runs that show a gap as no held-out run does, where they are long enough; returns
    what the user should know of it, nothing where none was cut.
    """
    long = [cases[c] for c in showing if (1.0 - FITTED) * len(cases[c].measured.time) >= 2 * LEAST]
    return "; ".join(f"no held-out run shows a gap like that of {case.name}: {_cut(cases, case)}" for case in long)


def _check_apart(file: ScenarioFile, runs: Sequence[tuple[Experiment, str]]) -> None:
    """No sample may be both fitted and judged on."""
    fitted, judged = ([e for e, use in runs if use == wanted] for wanted in ("train", "held_out"))
    for a, b in product(fitted, judged):
        same = a.recording is not None and b.recording is not None and a.recording.source == b.recording.source
        if same and max(a.window[0], b.window[0]) < min(a.window[1], b.window[1]):
            raise InputError(
                f"{file.path}: recordings.runs: {a.name} is fitted in {_shown(a)} and judged on in {_shown(b)}; "
                "expected windows that do not overlap"
            )


def _shown(experiment: Experiment) -> str:
    low, high = experiment.window
    return "all of it" if not np.isfinite([low, high]).any() else f"its window [{low:g}, {high:g}]"


def _repeated(runs: Sequence[tuple[Experiment, str]]) -> list[str]:
    """A sentence for every motion that is fitted in one repetition and judged on in another."""
    out = []
    for group in group_repetitions([replace(e, use=None) for e, _ in runs]):
        chosen = [runs[i] for i in group.indices]
        if len({use for _, use in chosen}) > 1:
            told = ", ".join(f"{e.name} ({use})" for e, use in chosen)
            out.append(f"one motion is fitted in some repetitions and judged on in others, which judges mildly: {told}")
    return out
