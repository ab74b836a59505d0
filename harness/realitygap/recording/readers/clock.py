"""Which clock a bag's times are on."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from realitygap.recording.lack import Lack
from realitygap.recording.readers.rows import out_of_order
from realitygap.trace.trace import Array

Nanoseconds = NDArray[np.int64]
AGREE = 1.0  # s: header clocks of two topics that are further apart are not one clock


@dataclass(frozen=True)
class Clock:
    """The clock of a bag: per topic the chosen times and the times of reception [ns], on a common origin; and whether
    it is that of reception, as header stamps are of no use.
    """

    note: str
    chosen: dict[str, Nanoseconds]
    received: dict[str, Nanoseconds]
    by_reception: bool = False

    def times(self, topic: str) -> tuple[Array, Array, NDArray[np.int64], Lack | None]:
        """Times [s] that strictly increase, times of reception [s], the messages they belong to, and what was mended.

        Both start at the bag's first message of any topic. Messages are sorted by time; of several with one stamp, the
        last is kept.
        """
        time = self.chosen[topic]
        order = np.argsort(time, kind="stable")
        mended = out_of_order(time, "messages")
        last = np.append(np.diff(time[order]) > 0, True)
        keep = order[last]
        if len(keep) < len(time):
            same = f"{len(time) - len(keep)} messages repeat the stamp of another and were dropped, of {len(time)}"
            text = same if mended is None else f"{mended.text}; {same}"
            mended = Lack("repeats", text, 1 - len(keep) / len(time))
        zero = min(int(t.min()) for t in self.chosen.values())
        zero_received = min(int(t.min()) for t in self.received.values())
        return (
            (time[keep] - zero) * 1e-9,
            (self.received[topic][keep] - zero_received) * 1e-9,
            keep,
            mended,
        )


def choose_clock(topics: dict[str, tuple[Nanoseconds, Nanoseconds]]) -> Clock:
    """Header stamps where every topic has them and they are one clock, else the times of reception.

    A stamp is closer to the moment of measurement than the time at which a recorder got the message. Stamps count as
    set where none is 0 and they advance with the messages; as one clock where their median distance to the times of
    reception agrees between topics within 1 s.

    Args:
        topics: stamps and times of reception [ns] by topic, each (m,).
    """
    stamps = {name: stamp for name, (stamp, _) in topics.items()}
    received = {name: receive for name, (_, receive) in topics.items()}
    problem = None
    for name, stamp in stamps.items():
        if (stamp == 0).any():
            problem = f"{name} has messages without a header stamp"
        elif len(np.unique(stamp)) * 2 < len(np.unique(received[name])):
            problem = f"the header stamps of {name} do not advance"
    offsets = {n: float(np.median(received[n] - stamps[n])) * 1e-9 for n in stamps}
    early, late = min(offsets, key=offsets.__getitem__), max(offsets, key=offsets.__getitem__)
    if problem is None and offsets[late] - offsets[early] > AGREE:
        jumps = {n: float(np.ptp(received[n] - stamps[n])) * 1e-9 for n in (early, late)}
        worse = max(jumps, key=jumps.__getitem__)
        problem = f"the header stamps of {early} and {late} are {offsets[late] - offsets[early]:.3g} s apart"
        if jumps[worse] > AGREE:
            problem = f"the clock of the header stamps of {worse} jumps by {jumps[worse]:.3g} s"
    if problem is None:
        return Clock("times are header stamps", stamps, received)
    return Clock(f"times are those of reception: {problem}", received, received, by_reception=True)
