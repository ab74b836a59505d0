"""Smooth functions with as few knots as still draw them: what is fitted again in simulations has few values."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from realitygap.missing.effort import MissingEffort
from realitygap.missing.fit import EffortSamples
from realitygap.missing.shape import Term, samples_of
from realitygap.missing.splines import Spline
from realitygap.trace.trace import Array

LOST = 0.01
"""The share of a function's variance over the samples that fewer knots may lose: a tenth of its size, as well as laws
are known."""
FEWEST = 2
"""Knots of each variable."""


def few_knots(runs: Sequence[MissingEffort], joint: str, terms: Sequence[Term]) -> list[Term]:
    """The same functions, each with as few knots as lose no more than `LOST`, and the values that suit these best."""
    samples = samples_of(runs, joint)[0]
    return [_fewer(samples, term) for term in terms]


@dataclass
class _Grid:
    """A function at its knots, and how many samples lie about each. `axis` is that of knots in `value` and `count`."""

    knots: list[Array]
    value: Array
    count: Array

    def cost(self, axis: int, k: int) -> float:
        """The squared error at the samples, roughly, of a function that is straight where the k-th knot was."""
        knots, value, count = self.knots[axis], np.moveaxis(self.value, axis, 0), np.moveaxis(self.count, axis, 0)
        if 0 < k < len(knots) - 1:
            part = (knots[k] - knots[k - 1]) / (knots[k + 1] - knots[k - 1])
            straight = (1 - part) * value[k - 1] + part * value[k + 1]
        else:
            straight = value[1 if k == 0 else -2]
        return float(np.sum(count[k] * (value[k] - straight) ** 2))

    def without(self, axis: int, k: int) -> "_Grid":
        """The rest; the samples about a knot that goes count at its neighbours."""
        knots = [np.delete(row, k) if i == axis else row for i, row in enumerate(self.knots)]
        count = np.moveaxis(self.count.copy(), axis, 0)
        for near in (max(k - 1, 1 - k), min(k + 1, 2 * (len(count) - 1) - k - 1)):
            count[near] += 0.5 * count[k]
        count = np.moveaxis(np.delete(count, k, axis=0), 0, axis)
        return _Grid(knots, np.delete(self.value, k, axis=axis), count)


def _fewer(samples: EffortSamples, term: Term) -> Term:
    one = Spline(term.variables, tuple(np.array(row) for row in term.knots))
    size = [len(row) for row in term.knots]
    columns, weight = _points(samples, one)
    full = one.design(columns)
    target = full @ np.array(term.values)
    spread = float(np.average((target - np.average(target, weights=weight)) ** 2, weights=weight))
    grid = _Grid(list(one.knots), np.reshape(term.values, size), (weight @ full).reshape(size))
    spline, values = one, np.array(term.values)

    def lighter() -> tuple[_Grid, Spline] | None:
        """The grid without the first knot, of those that seem to matter least, that loses little; None without one."""
        here = [(axis, k) for axis, row in enumerate(grid.knots) for k in range(len(row)) if len(row) > FEWEST]
        for at in sorted(here, key=lambda at: grid.cost(*at)):
            rest = grid.without(*at)
            fewer = Spline(term.variables, tuple(rest.knots))
            design = fewer.design(columns)
            values = _values(design, weight, target, rest.value.ravel())
            if np.average((design @ values - target) ** 2, weights=weight) <= LOST * spread:
                rest.value = values.reshape(rest.value.shape)
                return rest, fewer
        return None

    while (less := lighter()) is not None:
        grid, spline = less
        values = grid.value.ravel()
    knots = tuple(tuple(float(f"{x:.4g}") for x in row) for row in spline.knots)
    return Term(term.variables, knots, tuple(float(f"{x:.5g}") for x in values), term.share, term.periods)


def _points(samples: EffortSamples, one: Spline) -> tuple[dict[str, Array], Array]:
    """Where a function is to be the same, and the weights: at the samples, and as much at its knots, which lie close
    where it bends, as about rest, where there are few samples.
    """
    mesh = np.meshgrid(*one.knots, indexing="ij")
    columns = {v: np.concatenate([samples.columns[v], m.ravel()]) for v, m in zip(one.variables, mesh, strict=True)}
    return columns, np.concatenate([samples.weight / samples.weight.sum(), np.full(one.size, 1 / one.size)])


def _values(design: Array, weight: Array, target: Array, near: Array) -> Array:
    """The values whose function is closest to a target; where there are no samples, near what they were."""
    gram = (design * weight[:, None]).T @ design
    ridge = RIDGE * float(np.trace(gram)) / len(gram)
    right = design.T @ (weight * target) + ridge * near
    return np.asarray(np.linalg.solve(gram + ridge * np.eye(len(gram)), right))


RIDGE = 1e-4
"""Of what the samples tell of a value: so much it is drawn to where it was."""
