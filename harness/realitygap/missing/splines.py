"""Penalised splines over one or two variables (Eilers, Marx: Flexible smoothing with B-splines and penalties,
Statistical Science 11(2), 1996), linear between their knots as an `effort_map` is.

Knots lie closest where efforts change fastest: a signed variable's around 0, where friction jumps, and those of a time
since a reversal soon after it. Neighbours are penalised by their second differences along the knots, whatever their
distance, so that a jump and a slow slope cost alike.
"""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BSpline
from scipy.sparse import csr_array

from realitygap.trace.trace import Array

FINEST = 40.0
"""Periods a turn that a function of the angle can show: gears and cogging have up to about so many."""
A_PERIOD = 6.0
"""Knots for one of them."""
MOST = {"angle": 160, "speed": 41, "load": 31, "error": 31, "reversal": 21, "supply": 15, "temperature": 15}
"""Knots of a function of one variable at most."""
CROSSED = 11
"""Knots of each variable of a function of two."""
NEAR = 0.02
"""Of the range of a signed variable: within this its knots are closest."""
INSIDE = (0.005, 0.995)
"""Shares of the samples below the first and the last knot: what lies beyond has too few neighbours."""
FLAT = 1e-3
"""Of the penalty on first differences beside that on second ones: where there are no samples, a function goes on
as it is."""


@dataclass(frozen=True)
class Spline:
    """A function of one or two variables that is linear between knots, before its values are known.

    Attributes:
        variables: one or two names.
        knots: increasing, for each.
    """

    variables: tuple[str, ...]
    knots: tuple[Array, ...]

    @property
    def size(self) -> int:
        """How many values it has."""
        return int(np.prod([len(k) for k in self.knots]))

    def design(self, columns: dict[str, Array]) -> Array:
        """What each value adds at samples (t,) of the variables; of two, the second's knots run fastest. (t, size)."""
        parts = [_hats(columns[v], k) for v, k in zip(self.variables, self.knots, strict=True)]
        if len(parts) == 1:
            return np.asarray(parts[0].toarray())
        return np.asarray((parts[0].toarray()[:, :, None] * parts[1].toarray()[:, None, :]).reshape(-1, self.size))

    def penalty(self) -> Array:
        """The matrix P of the roughness vᵀPv of its values. Shape (size, size)."""
        out = np.zeros((self.size, self.size))
        sizes = [len(k) for k in self.knots]
        for axis, n in enumerate(sizes):
            own = FLAT * _differences(n, 1) + _differences(n, 2)
            sides = [own if i == axis else np.eye(m) for i, m in enumerate(sizes)]
            out += sides[0] if len(sides) == 1 else np.kron(sides[0], sides[1])
        return out


def spline(variables: tuple[str, ...], columns: dict[str, Array]) -> Spline:
    """The spline whose knots suit these samples of its variables."""
    return Spline(variables, tuple(_knots(v, columns[v], CROSSED if len(variables) > 1 else MOST[v])
                                   for v in variables))  # fmt: skip


def _knots(variable: str, samples: Array, most: int) -> Array:
    low, high = np.quantile(samples, INSIDE)
    if not high > low:
        return np.array([low, low + 1e-9 * max(abs(low), 1.0)])
    if variable == "angle":
        fine = int(np.ceil((high - low) / (2 * np.pi) * FINEST * A_PERIOD))
        return np.linspace(low, high, int(np.clip(fine, 8, most)))
    if variable in ("supply", "temperature"):
        return np.linspace(low, high, most)
    near = NEAR * max(abs(low), abs(high))
    if variable == "reversal":
        return np.asarray(near * np.expm1(np.linspace(np.log1p(low / near), np.log1p(high / near), most)))
    knots = near * np.sinh(np.linspace(np.arcsinh(low / near), np.arcsinh(high / near), most))
    return np.asarray(knots - knots[np.argmin(np.abs(knots))] if low < 0 < high else knots)


def _hats(samples: Array, knots: Array) -> csr_array:
    padded = np.concatenate([knots[:1], knots, knots[-1:]])
    return BSpline.design_matrix(np.clip(samples, knots[0], knots[-1]), padded, 1)


def _differences(n: int, order: int) -> Array:
    if n <= order:
        return np.zeros((n, n))
    d = np.diff(np.eye(n), n=order, axis=0)
    return np.asarray(d.T @ d)
