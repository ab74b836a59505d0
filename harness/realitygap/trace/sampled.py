"""A trace that comes in parts, at other times: a long motion need never be there as a whole."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from realitygap.trace.trace import Array, Trace

Gather = Callable[[Iterable[Trace], Array], Trace]
"""What makes one trace of parts and times, as `sampled` does."""


def sampled(parts: Iterable[Trace], time: Array) -> Trace:
    """Every signal but the command at other times, as `Trace.at` of the whole would give them.

    Args:
        parts: stretches of one trace, each after the other.
        time: increasing [s]. Shape (t,).
    """
    out: dict[str, Array] = {}
    joints, notes = (), ()  # type: tuple[str, ...], tuple[str, ...]
    for rows, here in stretches(parts, time):
        joints, notes = here.joints, here.notes
        for name in Trace.SIGNALS:
            value = getattr(here, name)
            if value is not None:
                if name not in out:
                    out[name] = np.empty((len(time), *value.shape[1:]))
                out[name][rows] = value
    signals: dict[str, Any] = out
    return Trace(time, joints, notes=notes, **signals)


def stretches(parts: Iterable[Trace], time: Array) -> Iterator[tuple[NDArray[np.int64], Trace]]:
    """The same one stretch after the other, each with the indices of its times; arguments as of `sampled`."""
    last: Trace | None = None
    done = 0
    for part in parts:
        if not len(part.time):
            continue
        part = replace(part, command=None)
        whole = part if last is None else _joined(last, part)
        last = part.rows(np.array([len(part.time) - 1]))
        until = int(np.searchsorted(time, part.time[-1]))
        if until > done:
            yield np.arange(done, until), whole.at(time[done:until])
            done = until
    if last is not None and done < len(time):
        yield np.arange(done, len(time)), last.at(time[done:])


def _joined(last: Trace, part: Trace) -> Trace:
    """A part after the last sample of the one before."""
    values = {n: (getattr(last, n), getattr(part, n)) for n in ("time", *Trace.SIGNALS)}
    joined: dict[str, Any] = {n: None if b is None else np.concatenate([a, b]) for n, (a, b) in values.items()}
    return replace(part, **joined)
