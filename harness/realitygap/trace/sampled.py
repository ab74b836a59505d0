"""A trace that comes in parts, at other times: a long motion need never be there as a whole."""

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import numpy as np

from realitygap.trace.trace import Array, Trace


def sampled(parts: Iterable[Trace], time: Array) -> Trace:
    """Every signal but the command at other times, as `Trace.at` of the whole would give them.

    Args:
        parts: stretches of one trace, each after the other.
        time: increasing [s]. Shape (t,).
    """
    out: dict[str, Array] = {}
    last: Trace | None = None
    done, joints, notes = 0, (), ()  # type: int, tuple[str, ...], tuple[str, ...]
    for part in parts:
        if not len(part.time):
            continue
        part = replace(part, command=None)
        whole = part if last is None else _joined(last, part)
        joints, notes, last = part.joints, part.notes, part.rows(np.array([len(part.time) - 1]))
        until = int(np.searchsorted(time, part.time[-1]))
        done = _put(out, whole, time, done, until)
    if last is not None:
        _put(out, last, time, done, len(time))
    signals: dict[str, Any] = out
    return Trace(time, joints, notes=notes, **signals)


def _put(out: dict[str, Array], part: Trace, time: Array, done: int, until: int) -> int:
    """Write what a part says of some of the times."""
    here = part.at(time[done:until])
    for name in Trace.SIGNALS:
        value = getattr(here, name)
        if value is not None:
            if name not in out:
                out[name] = np.empty((len(time), *value.shape[1:]))
            out[name][done:until] = value
    return max(done, until)


def _joined(last: Trace, part: Trace) -> Trace:
    """A part after the last sample of the one before."""
    values = {n: (getattr(last, n), getattr(part, n)) for n in ("time", *Trace.SIGNALS)}
    joined: dict[str, Any] = {n: None if b is None else np.concatenate([a, b]) for n, (a, b) in values.items()}
    return replace(part, **joined)
