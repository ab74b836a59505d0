"""Fitting changes in simulation: bounded least squares in the metric of the residuals."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import least_squares

from realitygap.diagnose.candidates.suspects import neutral, sizes, whole
from realitygap.diagnose.data.changes import Change
from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.fit.responses import residual, residuals
from realitygap.diagnose.likelihood.metric import Metric
from realitygap.robot.drive import Array

STEP, CONTACT_STEP = 0.05, 0.15
"""Step of a numerical derivative, as a part of the parameter's size: of a robot that is bolted down, and of a free
body, where contacts that come and go make small differences tell nothing but that."""
CONVERGED = 2e-3
"""A fit ends where a step would change the parameters by less than this share."""
SLAB = 4.0
"""Prior standard deviation of a named value about the model's own, in visible first sizes: a try at one size is to be
neither negligible nor absurd."""
LOOSE = 10.0
"""The same for shapes and stiffnesses, about their first guess."""
LEAST = 1e-6
"""A positive quantity is at least this many of its sizes."""
WORST = 1e6
"""The residual of a simulation that failed, in standard deviations."""


@dataclass(frozen=True)
class Fit:
    """Fitted changes.

    Attributes:
        changes: with their values.
        names: (number of the change, parameter) of every fitted value.
        residual: stacked, of the training motions. Shape (m,).
        slope: change of the residual per size of each value. Shape (m, p).
        size: of every value, in its unit. Shape (p,).
        prior: how far each value is from where its prior expects it, in standard deviations. Shape (p,).
    """

    changes: tuple[Change, ...]
    residual: Array
    names: tuple[tuple[int, str], ...] = ()
    slope: Array = field(default_factory=lambda: np.zeros((0, 0)))
    size: Array = field(default_factory=lambda: np.zeros(0))
    prior: Array = field(default_factory=lambda: np.zeros(0))

    @property
    def value(self) -> Array:
        """The fitted values. Shape (p,)."""
        return np.array([self.changes[i].parameters[name] for i, name in self.names])


class Space:
    """The fitted values of several changes as one vector, scaled by their sizes."""

    def __init__(self, problem: Problem, changes: Sequence[Change]) -> None:
        self.changes = list(changes)
        names, scale, low, high, first, expected, width, positive = [], [], [], [], [], [], [], []
        for i, change in enumerate(self.changes):
            size, zero = sizes(problem.plant, change.suspect), neutral(problem.plant, change.suspect)
            for name in change.free:
                p, value = change.suspect.kind.parameter(name), change.parameters[name]
                names.append((i, name))
                plain = np.isfinite(zero[name]) and not p.shape and not whole(change.suspect.kind)
                scale.append(max(size[name] if plain or value == 0.0 else abs(value), 1e-12))
                expected.append(zero[name] if plain else value)
                width.append(SLAB if plain else LOOSE)
                positive.append(plain and p.absent is None and p.low >= 0.0 and zero[name] > 0.0)
                low.append(p.low)
                high.append(p.high)
                first.append(min(max(value, p.low), p.high))
        self.names = tuple(names)
        self.scale, self.low, self.high = np.array(scale), np.array(low), np.array(high)
        self.first = np.array(first) / self.scale
        self.expected, self.width = np.array(expected) / self.scale, np.array(width)
        self.positive = np.array(positive, dtype=bool)
        self.step = CONTACT_STEP if problem.plant.model.floating else STEP

    def bounds(self) -> tuple[Array, Array]:
        """Lower and upper bounds of the scaled values."""
        return self.low / self.scale, self.high / self.scale

    def prior(self, x: Array) -> Array:
        """How far scaled values are from where their priors expect them, in standard deviations. Shape (p,).

        The logarithm of a quantity that is there and positive counts: a tenth of a mass is as odd as its tenfold.
        """
        ratio = np.where(self.positive, np.maximum(x, LEAST) / np.where(self.positive, self.expected, 1.0), 1.0)
        far = np.where(self.positive, self.expected * np.log(ratio), x - self.expected)
        return np.asarray(far / self.width)

    def prior_slope(self, x: Array) -> Array:
        """The derivative of that. Shape (p,)."""
        return np.asarray(np.where(self.positive, self.expected / np.maximum(x, LEAST), 1.0) / self.width)

    def at(self, x: Array) -> tuple[Change, ...]:
        """The changes at scaled values."""
        values: list[dict[str, float]] = [{} for _ in self.changes]
        for (i, name), v, low, high in zip(self.names, x * self.scale, self.low, self.high, strict=True):
            values[i][name] = float(min(max(v, low), high))
        return tuple(c.at(v) for c, v in zip(self.changes, values, strict=True))

    def steps(self, x: Array) -> list[tuple[Array, float]]:
        """A moved vector for every value, and how far it moved."""
        out = []
        high = self.bounds()[1]
        for k in range(len(x)):
            step = self.step * max(abs(x[k]), 0.3)
            if x[k] + step > high[k]:
                step = -step
            moved = x.copy()
            moved[k] += step
            out.append((moved, step))
        return out


def fit(
    simulations: Simulations,
    changes: Sequence[Change],
    train: Sequence[int],
    metric: Metric,
    coarse: Sequence[float],
    budget: int = 8,
) -> Fit | None:
    """Fit changes jointly to the training motions; None where they cannot be simulated.

    Args:
        simulations: of the problem.
        changes: with first guesses.
        train: cases to fit to.
        metric: of the stacked residual.
        coarse: the least faithful share of the step rate, by case, for derivatives.
        budget: steps of the solver at most.
    """
    space = Space(simulations.problem, changes)
    before = residual(simulations, changes, train)
    if before is None:
        return None
    if not len(space.first):
        return Fit(tuple(changes), before)
    failed = np.full(len(metric(np.zeros(len(before)))), WORST)
    slopes: dict[bytes, Array] = {}

    def residuals_at(x: Array) -> Array:
        r = residual(simulations, space.at(x), train)
        return np.concatenate([failed if r is None else metric(r), space.prior(x)])

    def jacobian(x: Array) -> Array:
        slopes[x.tobytes()] = slope(simulations, space, x, train, coarse)
        return np.vstack([metric(slopes[x.tobytes()]), np.diag(space.prior_slope(x))])

    solution = least_squares(
        residuals_at, space.first, jac=jacobian, bounds=space.bounds(), max_nfev=budget,
        xtol=CONVERGED, ftol=1e-6, gtol=1e-10, x_scale=np.maximum(np.abs(space.first), 0.3),
    )  # fmt: skip
    x = solution.x
    after = residual(simulations, space.at(x), train)
    if after is None:
        return None
    last = slopes[x.tobytes()] if x.tobytes() in slopes else slope(simulations, space, x, train, coarse)
    return Fit(space.at(x), after, space.names, last, space.scale, space.prior(x))


def slope(
    simulations: Simulations,
    space: Space,
    x: Array,
    train: Sequence[int],
    coarse: Sequence[float],
    values: Sequence[int] | None = None,
) -> Array:
    """The change of the stacked residual per scaled value, by differences, simulated side by side. Shape (m, p).

    Args:
        simulations: of the problem.
        space: of the values.
        x: where.
        train: the cases.
        coarse: how coarsely each is simulated.
        values: the numbers of the values that count; None for all.
    """
    moved = space.steps(x)
    moved = moved if values is None else [moved[k] for k in values]
    still, *answers = residuals(simulations, [space.at(x), *(space.at(y) for y, _ in moved)], train, coarse)
    if still is None:
        still = residual(simulations, space.at(x), train)
        assert still is not None
    columns = [
        np.zeros(len(still)) if a is None else np.nan_to_num(a - still) / s
        for a, (_, s) in zip(answers, moved, strict=True)
    ]
    return np.column_stack(columns) if columns else np.zeros((len(still), 0))
