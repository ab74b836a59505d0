"""How far the engines are from each other: simulated joint angles of one engine against another's, cell by cell."""

from dataclasses import dataclass, replace
from itertools import combinations
from pathlib import Path

import numpy as np

from realitygap.compare.traces import read_traces
from realitygap.page.style import AXES
from realitygap.report.each import Each, one_by_one
from realitygap.report.folder import Results, cell_key
from realitygap.trace.trace import Array, Trace


@dataclass(frozen=True)
class Spread:
    """The root mean square difference of joint angles of two engines over `cells` pairs of matched cells."""

    first: str
    second: str
    degrees: float
    cells: int

    @property
    def radians(self) -> float:
        """The same in radians."""
        return float(np.deg2rad(self.degrees))


def spread(results: Results, each: Each = one_by_one) -> list[Spread]:
    """The spread of every pair of engines, in the order of the table. Prismatic joints are left out.

    `each` works out one condition after the other, in other processes where there are some. Where positions are given
    and not simulated, as in motions that are followed, there is none.
    """
    if not results.gaps.empty and not (results.gaps["signal"] == "position").any():
        return []
    contexts: dict[tuple[str, ...], dict[str, Path]] = {}
    others = [a for a in AXES if a != "engine"]
    for record in results.cells.to_dict("records"):
        path = results.traces.get(cell_key(record))
        if path is not None:
            contexts.setdefault(tuple(str(record[a]) for a in others), {})[str(record["engine"])] = path
    squares: dict[tuple[str, str], list[float]] = {}
    ordered = [{e: paths[e] for e in results.engines if e in paths} for paths in contexts.values()]
    for found in each(_mean_squares, ordered):
        for pair, square in found.items():
            squares.setdefault(pair, []).append(square)
    return [
        Spread(*pair, float(np.rad2deg(np.sqrt(np.mean(squares[pair])))), len(squares[pair]))
        for pair in combinations(results.engines, 2)
        if pair in squares
    ]


def _mean_squares(paths: dict[str, Path]) -> dict[tuple[str, str], float]:
    """Of every two engines of one condition."""
    turned = {engine: found for engine, path in paths.items() if (found := _hinges(path)) is not None}
    return {(a, b): _mean_square(turned[a], turned[b]) for a, b in combinations(turned, 2)}


def _hinges(path: Path) -> Trace | None:
    """The simulated angles of the joints that turn; None where there are none."""
    traces = read_traces(path, ("position",))
    turning = [i for i, joint in enumerate(traces.joints) if not joint.prismatic]
    position = traces.simulated.position
    return None if position is None or not turning else replace(traces.simulated, position=position[:, turning])


def _mean_square(one: Trace, other: Trace) -> float:
    """Of the difference of the angles, on every step of one that both have [rad²]."""
    clock: Array = one.time[(one.time >= other.time[0]) & (one.time <= other.time[-1])]
    a, b = one.at(clock).position, other.at(clock).position
    assert a is not None
    assert b is not None
    return float(np.mean((a - b) ** 2))
