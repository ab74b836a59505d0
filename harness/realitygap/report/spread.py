"""How far the engines are from each other: simulated joint angles of one engine against another's, cell by cell."""

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from realitygap.page.style import AXES
from realitygap.report.curves import read_curves, unpack
from realitygap.report.folder import Results, cell_key
from realitygap.robot.drive import Array


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


def spread(results: Results) -> list[Spread]:
    """The spread of every pair of engines, in the order of the table. Prismatic joints are left out."""
    contexts: dict[tuple[str, ...], dict[str, Array]] = {}
    others = [a for a in AXES if a != "engine"]
    for record in results.cells.to_dict("records"):
        path = results.curves.get(cell_key(record))
        if path is not None:
            context = tuple(str(record[a]) for a in others)
            contexts.setdefault(context, {})[str(record["engine"])] = _angles(read_curves(path))
    out = []
    for first, second in combinations(results.engines, 2):
        pairs = [(c[first], c[second]) for c in contexts.values() if first in c and second in c]
        squares = [np.mean((a - b) ** 2) for a, b in pairs if a.size and a.shape == b.shape]
        if squares:
            out.append(Spread(first, second, float(np.sqrt(np.mean(squares))), len(squares)))
    return out


def _angles(content: dict[str, dict[str, dict[str, dict[str, object]]]]) -> Array:
    """The simulated joint angles of a cell [deg]. Shape (joints, t)."""
    series = content["simulated"].get("position", {})
    return np.array([unpack(s) for s in series.values() if s["unit"] == "deg"])
