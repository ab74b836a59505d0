"""Messages of one topic that differ in their numbers only, decoded many at a time.

A recorder's messages hold the same names in the same places, again and again. Where the numbers of a message stand is
learnt from one: with other numbers in it, the library that reads messages writes it again, and what moved are the
numbers. What has all other bytes in common is read as an array; anything else goes message by message.
"""

from array import array
from collections.abc import Callable
from dataclasses import dataclass
from operator import attrgetter
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from realitygap.recording.readers.messages import JointMessages, Refused
from realitygap.trace.trace import Array

AT_ONCE = 2048
"""Messages that are decoded together."""
LESSONS = 20
"""Messages that are learnt from at most: a topic of many shapes is read message by message."""
STAMP = np.dtype([("sec", "<u4"), ("nanosec", "<u4")])
SECOND = 1_000_000_000


class Collector(Protocol):
    """What takes the messages of one topic."""

    def take(self, message: Any) -> bool:
        """Keep the message; False for one of somebody else."""


class Format(Protocol):
    """What turns the bytes of messages into messages and back."""

    def deserialize(self, data: bytes, kind: str) -> Any:
        """The message in bytes."""

    def serialize(self, message: Any, kind: str) -> bytes:
        """Its bytes."""


@dataclass(frozen=True)
class Pattern:
    """Where the numbers of a message stand.

    Attributes:
        bytes: those of one message. Shape (size,).
        fixed: which of them are no numbers. Shape (size,).
        names: of the joints.
        places: signal -> offset, type and count of its numbers; count 0 where the message holds none.
        stamp: offset of the header's stamp; None where there is no header.
    """

    bytes: NDArray[np.uint8]
    fixed: NDArray[np.bool_]
    names: tuple[str, ...]
    places: dict[str, tuple[int, np.dtype[Any], int]]
    stamp: int | None

    def values(self, rows: NDArray[np.uint8]) -> dict[str, Array]:
        """The numbers of messages by signal, each (k, count). Shape of `rows`: (k, size)."""
        return {signal: self._read(rows, *place).astype(float, copy=False) for signal, place in self.places.items()}

    def stamps(self, rows: NDArray[np.uint8]) -> NDArray[np.int64]:
        """The stamps [ns], 0 where there are none. Shape (k,)."""
        if self.stamp is None:
            return np.zeros(len(rows), dtype=np.int64)
        found = self._read(rows, self.stamp, STAMP, 1)[:, 0]
        return np.asarray(found["sec"].astype(np.int64) * SECOND + found["nanosec"].astype(np.int64))

    def _read(self, rows: NDArray[np.uint8], place: int, kind: np.dtype[Any], count: int) -> NDArray[Any]:
        if not count:
            return np.empty((len(rows), 0))
        part = np.ascontiguousarray(rows[:, place : place + count * kind.itemsize])
        return part.view(kind)


def learnt(form: Format, data: bytes, kind: str, collector: Collector) -> Pattern | None:
    """The pattern of a message; None where its numbers do not stand together, or cannot be told apart."""
    if not isinstance(collector, JointMessages) or not collector.plain:
        return None
    message = form.deserialize(data, kind)
    names, values = collector.read(message)
    found: dict[str, bytes] = {}
    for seed, (signal, path) in enumerate(collector.paths.items()):
        value = values[signal]
        if not isinstance(value, np.ndarray) or value.dtype.kind != "f":
            return None
        other = np.random.default_rng(seed).random(len(value)).astype(value.dtype)
        owner, _, field = path.rpartition(".")
        setattr(attrgetter(owner)(message) if owner else message, field, other)
        found[signal] = other.tobytes()
    stamp = None
    header = getattr(message, "header", None)
    if header is not None:
        header.stamp.sec, header.stamp.nanosec = 0x2B6D3C51, 0x1D4A9E37
        stamp = np.array([(0x2B6D3C51, 0x1D4A9E37)], STAMP).tobytes()
    try:
        other_bytes = form.serialize(message, kind)
    except Exception:  # what the library cannot write again is read message by message
        return None
    if len(other_bytes) != len(data) or any(other_bytes.count(b) != 1 for b in (*found.values(), stamp) if b):
        return None
    free = np.zeros(len(data), dtype=bool)
    places = {}
    for signal, sought in found.items():
        place = other_bytes.index(sought) if sought else 0
        free[place : place + len(sought)] = True
        places[signal] = place, values[signal].dtype, len(values[signal])
    at = None if stamp is None else other_bytes.index(stamp)
    if at is not None:
        free[at : at + STAMP.itemsize] = True
    own = np.frombuffer(data, dtype=np.uint8)
    if (own != np.frombuffer(other_bytes, dtype=np.uint8))[~free].any():
        return None  # written by another program, in another way
    return Pattern(own, ~free, names, places, at)


class Taking:
    """A topic while it is read: what takes its messages, and when those that were kept were stamped and received [ns].

    `stamp_of` tells the stamp of a message [ns], 0 where it has none.
    """

    def __init__(self, form: Format, collector: Collector, stamp_of: Callable[[Any], int]) -> None:
        self.collector = collector
        self.stamps, self.received = array("q"), array("q")
        self._form, self._stamp_of = form, stamp_of
        self._kind, self._pattern = "", None  # type: str, Pattern | None
        self._lessons = LESSONS if isinstance(collector, JointMessages) else 0
        self._waiting: list[bytes] = []
        self._arrivals = array("q")

    def take(self, received: int, data: bytes, kind: str) -> None:
        """A message of a type, in the order of reception [ns].

        Raises:
            Refused: for a message that cannot be used, sometimes not until later ones came.
        """
        if self._pattern is not None and len(data) == len(self._pattern.bytes) and kind == self._kind:
            self._waiting.append(data)
            self._arrivals.append(received)
            if len(self._waiting) == AT_ONCE:
                self.finish()
            return
        self.finish()
        self._kind = kind
        self._one(received, data)
        if self._lessons:
            self._lessons -= 1
            self._pattern = learnt(self._form, data, kind, self.collector)

    def finish(self) -> None:
        """Take what is waiting."""
        waiting, arrivals = self._waiting, self._arrivals
        self._waiting, self._arrivals = [], array("q")
        if not waiting:
            return
        assert self._pattern is not None
        assert isinstance(self.collector, JointMessages)
        rows = np.frombuffer(b"".join(waiting), dtype=np.uint8).reshape(len(waiting), -1)
        if ((rows != self._pattern.bytes) & self._pattern.fixed).any():
            for received, data in zip(arrivals, waiting, strict=True):
                self._one(received, data)
        elif self.collector.take_many(self._pattern.names, self._pattern.values(rows), len(rows)):
            self.received.extend(arrivals)
            self.stamps.frombytes(self._pattern.stamps(rows).tobytes())

    def _one(self, received: int, data: bytes) -> None:
        message = self._form.deserialize(data, self._kind)
        try:
            kept = self.collector.take(message)
        except Refused as error:
            raise Refused(f"message {len(self.received) + 1}: {error}") from None
        if kept:
            self.received.append(received)
            self.stamps.append(self._stamp_of(message))
