"""What a recording lacks, and the sentences on it that a person reads before the long work begins."""

from collections.abc import Iterable
from dataclasses import dataclass

NOTICED = 0.05
"""The part of a recording from which on it is told what it lacks: buses lose single readings and nobody minds."""


@dataclass(frozen=True)
class Lack:
    """What is not as it should be in a recording: its kind, one sentence, and which part of the recording it is.

    Samples or readings are absent or were dropped (`samples`, `readings`, `pause`, `repeats` or `cut`), stamps are of
    no use (`clock`), turns of an encoder are not counted in it (`turns`), or something was mended in which nothing is
    lost: rows that came out of `order`, or are `copies` of others.
    """

    kind: str
    text: str
    part: float = 0.0

    @property
    def of_readings(self) -> bool:
        """Whether readings are absent or were dropped."""
        return self.kind not in ("clock", "turns", "order", "copies")


def noticed(found: Iterable[tuple[str, Lack]]) -> list[str]:
    """One sentence of every kind on lacks that are a part of their recording, which is named: the largest of them, and
    of how many more recordings.
    """
    kinds: dict[str, list[tuple[str, Lack]]] = {}
    for name, lack in found:
        if lack.part >= NOTICED:
            kinds.setdefault(lack.kind, []).append((name, lack))
    out = []
    for same in kinds.values():
        name, most = max(same, key=lambda named: named[1].part)
        more = len({n for n, _ in same}) - 1
        also = f" (and in {more} other recording{'s' * (more > 1)})" if more else ""
        out.append(f"{name}: {most.text}{also}")
    return out
