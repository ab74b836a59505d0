"""Windows: a motion in pieces, each of which is simulated from the state that was measured where it begins.

That is the residual of multiple shooting (Bock 1981), with the states taken from the readings: what a motion does
after it has forgotten how it began is compared with nothing. How uncertain such a state is counts among the floors.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from realitygap.diagnose.data.case import Case
from realitygap.diagnose.data.moment import Moments
from realitygap.simulate.commands import Commands
from realitygap.simulate.experiment import Experiment
from realitygap.trace.trace import Trace

FEWEST = 10
"""Samples of a window: fewer tell little beyond where it begins."""
SLACK = 0.25
"""A window may begin later by this share of its length, where the state is known better."""
PAST = 2.0
"""Commands that were sent up to this long before a window [s] are still on their way, or a profile follows them."""


def cut(case: Case, length: float) -> Case:
    """A case whose motion is simulated in windows of about a length [s]; as it is, where that holds too few samples.

    It begins with its first sample: what a case compares starts at a measured state. A pause of the readings that is as
    long as a window parts windows: in it a motion forgets how it began, too.
    """
    time = case.measured.time
    period = float(np.median(np.diff(time)))
    size = int(min(length / period, len(time)))
    if size < FEWEST or len(time) < FEWEST:
        return case
    moments, begins = Moments(case), list[int]()
    pauses = np.flatnonzero(np.diff(time) > length) + 1
    for first, last in pairwise([0, *pauses, len(time)]):
        begins.append(int(first))
        while begins[-1] + size + FEWEST <= last:
            ahead = begins[-1] + size
            late = range(ahead, min(ahead + int(SLACK * size), last - FEWEST) + 1)
            begins.append(min(late, key=moments.doubt))
    over = time + case.experiment.scenario.timestep  # where a window ends after whose last reading none follows
    ends = [*(over[k - 1] if k in pauses else time[k] for k in begins[1:]), over[-1]]
    windows = tuple(_window(case, moments, k, end) for k, end in zip(begins, ends, strict=True))
    return replace(case, windows=windows, length=length)


def begun(case: Case, number: int) -> list[Experiment]:
    """What is left of a case's motion from so many of its samples on, the first and others evenly after it, each from
    its measured state; none where there are too few samples between them.
    """
    time, moments = case.measured.time, Moments(case)
    end, apart = float(time[-1]) + case.experiment.scenario.timestep, len(time) // number
    return [_window(case, moments, k * apart, end) for k in range(number)] if apart >= FEWEST else []


def _window(case: Case, moments: Moments, k: int, end: float) -> Experiment:
    """The piece of a case's motion from sample k to a time on the recording's clock [s]."""
    whole, begin = case.experiment, float(case.measured.time[k])
    assert whole.recording is not None
    sent = whole.commands.time - (begin - whole.begin)
    first = max(int(np.searchsorted(sent, -PAST, side="right")) - 1, 0)
    last = max(int(np.searchsorted(sent, end - begin, side="right")) + 1, first + 1)
    return replace(
        whole,
        recording=replace(whole.recording, trace=case.measured.between(begin, end)),
        commands=Commands(sent[first:last], whole.commands.value[first:last], whole.commands.held),
        begin=begin,
        duration=float(end - begin),
        midway=moments.at(k),
    )


def joined(windows: Sequence[Experiment], traces: Sequence[Trace]) -> Trace:
    """The simulations of windows one after the other, each up to where the next one begins."""
    if len(traces) == 1:
        return traces[0]
    ends = [after.begin for _, after in pairwise(windows)]
    kept = [t.rows(t.time < end - 1e-9) for t, end in zip(traces, [*ends, np.inf], strict=True)]
    there = {s for s in Trace.SIGNALS if getattr(kept[0], s) is not None}
    signals = {s: np.concatenate([getattr(t, s) for t in kept]) for s in there}
    return replace(kept[0], time=np.concatenate([t.time for t in kept]), **signals)  # type: ignore[arg-type]
