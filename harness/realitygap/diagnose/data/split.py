"""Which motions are fitted and which are kept to judge on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import product

import numpy as np

from realitygap.compare.comparison import RepeatedMotion
from realitygap.diagnose.data.case import Case
from realitygap.files.errors import InputError
from realitygap.files.found import counted
from realitygap.recording.align import group_repetitions
from realitygap.scenario.file import ScenarioFile
from realitygap.simulate.experiment import Experiment

LEAST = 10
"""Samples that a motion must have to be fitted or judged on."""
FITTED = 0.6
"""The share of a single run that is fitted; the rest is judged on."""


def split(file: ScenarioFile, cases: Sequence[Case], motions: Sequence[RepeatedMotion]) -> tuple[list[Case], str]:
    """Every case marked as `train` or `held_out`, a single run cut in two, and what the user should know of it.

    Args:
        file: the scenario.
        cases: the motions with their noise.
        motions: the same, with all repetitions.

    Raises:
        InputError: where all runs are held out, the same samples are fitted and judged on, or too few are left.
    """
    cases, said = _marked(file, cases)
    for case in cases:
        if len(case.measured.time) < LEAST:
            raise InputError(
                f"{file.path}: recordings.runs: {case.name} holds {counted(len(case.measured.time), 'sample')} to "
                f"{'judge on' if case.use == 'held_out' else 'fit'}; expected at least {LEAST}"
            )
    runs = [(e, c.use) for c, m in zip(cases, motions, strict=False) for e in m.experiments]
    _check_apart(file, runs)
    return cases, "; ".join([said, *_repeated(runs)] if said else _repeated(runs))


def _marked(file: ScenarioFile, cases: Sequence[Case]) -> tuple[list[Case], str]:
    uses = {c.use for c in cases}
    if uses == {"held_out"}:
        raise InputError(
            f"{file.path}: recordings.runs: found use: held_out in every run; expected some to fit (use: train)"
        )
    if "held_out" in uses:
        return [replace(c, use=c.use or "train") for c in cases], ""
    if len(cases) > 1:
        kept = {i for i in range(len(cases)) if i % 3 == 2 or (len(cases) == 2 and i == 1)}
        marked = [replace(c, use="held_out" if i in kept else "train") for i, c in enumerate(cases)]
        names = ", ".join(c.name for c in marked if c.use == "held_out")
        which = "every third motion" if len(cases) > 2 else "the second of two motions"
        return marked, f"no run was marked held_out: {which} was kept back ({names})"
    (only,) = cases
    time = only.measured.time
    middle = float(time[0] + FITTED * (time[-1] - time[0]))
    first = replace(only, measured=only.measured.between(-np.inf, middle), use="train")
    rest = replace(only, measured=only.measured.between(middle, np.inf), use="held_out", name=f"{only.name} (rest)")
    return [first, rest], f"there is one run: it was fitted up to {middle:.2f} s and judged on the rest"


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
