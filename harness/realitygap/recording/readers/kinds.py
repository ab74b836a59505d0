"""The kinds of messages of one topic: those of several publishers name different joints, each at times of its own."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from realitygap.recording.streams import Samples
from realitygap.trace.trace import Array

Rows = NDArray[np.intp]
Mask = NDArray[np.bool_]
LISTED = 3
"""Kinds of messages that a sentence lists; the others it counts."""


@dataclass(frozen=True)
class Kind:
    """Messages that name the same joints: which joints, what they are called in messages to the user, and which they
    are (k,).
    """

    joints: str
    name: str
    rows: Rows


def kinds_of(topic: str, joints: Sequence[str], present: Mask | None, count: int) -> list[Kind]:
    """The kinds of the messages of a topic, so that stamps are compared with those of the same publisher.

    Args:
        topic: what a single kind is called.
        joints: n names.
        present: Shape (count, n), which joints a message names; None: all.
        count: of messages.
    """
    if present is None:
        return [Kind("", topic, np.arange(count))]
    named, which = np.unique(present, axis=0, return_inverse=True)
    if len(named) == 1:
        return [Kind("", topic, np.arange(count))]
    called = [", ".join(j for j, there in zip(joints, row, strict=True) if there) for row in named]
    return [Kind(name, f"{topic} ({name})", np.flatnonzero(which.ravel() == i)) for i, name in enumerate(called)]


def told_kinds(kinds: Sequence[Kind]) -> str:
    """That messages of several kinds were brought together; "" for one kind."""
    if len(kinds) < 2:
        return ""
    often = sorted(kinds, key=lambda kind: -len(kind.rows))
    listed = "; ".join(f"{len(kind.rows)} of {kind.joints}" for kind in often[:LISTED])
    more = f"; {len(kinds) - LISTED} more" if len(kinds) > LISTED else ""
    return f"comes in {len(kinds)} kinds of messages ({listed}{more}), which are merged joint by joint"


def in_order(
    source: str,
    joints: tuple[str, ...],
    signals: dict[str, Array],
    present: Mask | None,
    parts: Sequence[tuple[Array, Array, Rows]],
) -> Samples:
    """The samples of a topic.

    Messages of several kinds with one stamp become one sample, in which a joint is what the later one says of it, and
    NaN where none names it.

    Args:
        source: names the topic in messages to the user.
        joints: n names.
        signals: those of all messages, as they came.
        present: Shape (m, n), which joints they name; None: all.
        parts: of every kind the times [s], which increase, the times of reception [s], and which messages these are.
    """
    time, received, rows = (np.concatenate(each) for each in zip(*parts, strict=True))
    if len(parts) > 1:
        order = np.argsort(time, kind="stable")
        time, received, rows = time[order], received[order], rows[order]
    if len(next(iter(signals.values()), rows)) > len(rows) or (np.diff(rows) < 0).any():
        signals = {name: value[rows] for name, value in signals.items()}
        present = None if present is None else present[rows]
    if len(parts) < 2 or present is None:
        return Samples(source, time, signals, joints, present, received)
    ends = np.flatnonzero(np.append(np.diff(time) > 0, True))
    last = np.maximum.accumulate(np.where(present, np.arange(len(time))[:, None], -1))[ends]
    there = last >= np.append(0, ends[:-1] + 1)[:, None]
    merged = {
        name: np.where(there, np.take_along_axis(value, np.maximum(last, 0), axis=0), np.nan)
        for name, value in signals.items()
    }
    return Samples(source, time[ends], merged, joints, there, received[ends])
