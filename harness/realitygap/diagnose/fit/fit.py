"""Fitting suspects in simulation: bounded least squares with a robust loss, and how sure the result is."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.optimize import OptimizeResult, least_squares

from realitygap.diagnose.candidates.suspects import fitted, neutral, sizes
from realitygap.diagnose.data.decoys import KNOWN
from realitygap.diagnose.data.problem import Change, Problem, Suspect
from realitygap.robot.drive import Array

STEP, CONTACT_STEP = 0.02, 0.15
"""Step of a numerical derivative, as a part of the parameter's size: of a robot that is bolted down, and of a
free body, where contacts that come and go make small differences tell nothing but that."""
ELSEWHERE = (0.7, 1.4)
"""A fit is tried again from these multiples of the newest change: friction that holds a joint makes it rough."""
BETTER = 0.99
"""It goes on from there where the loss is below this share."""
OUTLIER = 5.0
"""A residual beyond this many times its root mean square counts less."""
CLOSE = 1e-3
"""A fit ends where a step would change the parameters by less than this share."""
PRIOR = 1e-3
"""Pull towards the first guess per size, so that a parameter without influence stays where it is."""


@dataclass
class Fit:
    """Fitted changes and how well they explain the motions.

    Attributes:
        changes: the suspects with their values.
        cost: mean squared residual per case; 1 is the floor.
        names: (suspect number, parameter) of every fitted value.
        value, deviation: fitted values and their standard deviations. Shape (p,).
        step_per_case: Shape (cases, p): how far each motion alone would move the values (Gauss-Newton).
        weight_per_case: Shape (cases, p): curvature of each motion: how much it says about each value.
        misfit: the gap in floors that counts as noise (see `Problem.levels`).
    """

    changes: list[Change]
    cost: dict[int, float] = field(default_factory=dict)
    names: list[tuple[int, str]] = field(default_factory=list)
    value: Array = field(default_factory=lambda: np.zeros(0))
    deviation: Array = field(default_factory=lambda: np.zeros(0))
    step_per_case: Array = field(default_factory=lambda: np.zeros((0, 0)))
    weight_per_case: Array = field(default_factory=lambda: np.zeros((0, 0)))
    evaluations: int = 0
    misfit: float = 1.0

    def mean_cost(self, cases: Sequence[int]) -> float:
        """Mean squared residual over some cases, each counting alike."""
        return float(np.mean([self.cost[c] for c in cases]))


def start(problem: Problem, suspect: Suspect) -> Change:
    """A suspect at a first guess: its neutral value plus a sensible size."""
    effect = KNOWN[suspect.effect]
    first = effect.first_size(problem.plant, suspect.indices[0])
    zero = neutral(problem.plant, suspect)
    free = tuple(p.name for p in fitted(effect))
    values = {}
    for p in effect.parameters:
        value = first[p.name]
        if p.name in free and value == zero[p.name]:
            value = zero[p.name] + sizes(problem.plant, suspect)[p.name]
        values[p.name] = float(np.clip(value, p.low, p.high))
        if p.name not in free and p.default is not None:
            values[p.name] = p.default
    return Change(suspect, tuple(values.items()), free)


class _Space:
    """The fitted values of several changes as one vector, scaled by their sizes."""

    def __init__(self, problem: Problem, changes: Sequence[Change]) -> None:
        self.changes = list(changes)
        self.names: list[tuple[int, str]] = []
        scale, low, high, first = [], [], [], []
        for i, change in enumerate(self.changes):
            effect = KNOWN[change.suspect.effect]
            size = sizes(problem.plant, change.suspect)
            for name in change.free:
                p = effect.parameter(name)
                self.names.append((i, name))
                value = change.parameters[p.name]
                scale.append(max(size[name], 1e-12))
                low.append(p.low)
                high.append(p.high)
                first.append(min(max(value, p.low), p.high))
        self.scale, self.low, self.high = np.array(scale), np.array(low), np.array(high)
        self.first = np.array(first) / self.scale
        self.step = CONTACT_STEP if problem.plant.model.floating else STEP

    def bounds(self) -> tuple[Array, Array]:
        return self.low / self.scale, self.high / self.scale

    def elsewhere(self, problem: Problem, x: Array) -> list[Array]:
        """Where else to look: the newest change made larger and smaller, its shape kept."""
        last = len(self.changes) - 1
        zero = neutral(problem.plant, self.changes[last].suspect)
        out = []
        for factor in ELSEWHERE:
            y = x.copy()
            for k, (i, name) in enumerate(self.names):
                shape = KNOWN[self.changes[i].suspect.effect].parameter(name).shape
                if i == last and not shape and np.isfinite(zero[name]):
                    origin = zero[name] / self.scale[k]
                    y[k] = origin + factor * (x[k] - origin)
            out.append(np.clip(y, *self.bounds()))
        return [y for y in out if (y != x).any()]

    def at(self, x: Array) -> list[Change]:
        values = [change.parameters for change in self.changes]
        for (i, name), v, low, high in zip(self.names, x * self.scale, self.low, self.high, strict=True):
            values[i][name] = float(min(max(v, low), high))
        return [replace(c, values=tuple(v.items())) for c, v in zip(self.changes, values, strict=True)]


class _Residual:
    """The residuals of the training motions over a vector of scaled values; what was simulated is kept in `memo`."""

    def __init__(self, problem: Problem, space: _Space, train: Sequence[int], misfit: float) -> None:
        self.problem, self.space, self.train = problem, space, train
        self.levels = [problem.levels(c, misfit) for c in train]
        self.memo: dict[bytes, list[Array]] = {}

    def __call__(self, x: Array) -> Array:
        """Weighted so that every motion counts alike, with the pull towards the first guess at the end."""
        return self._weighted(self.simulated(x), x)

    def simulated(self, x: Array) -> list[Array]:
        """As simulated, by motion."""
        key = x.tobytes()
        if key not in self.memo:
            self.memo[key] = [self.problem.residuals(self.space.at(x), c) for c in self.train]
        return self.memo[key]

    def jacobian(self, x: Array) -> Array:
        """By differences, as coarsely as is faithful; a step that is exact serves the solver again."""
        exact = all(self.problem.cases[c].coarse == 1.0 for c in self.train)
        return _differences(self if exact else self._coarse, x, self.space)

    def _coarse(self, x: Array) -> Array:
        return self._weighted([self.problem.coarse_residuals(self.space.at(x), c) for c in self.train], x)

    def _weighted(self, parts: Sequence[Array], x: Array) -> Array:
        rows = [_alike(level * r) for level, r in zip(self.levels, parts, strict=True)]
        return np.concatenate([*rows, PRIOR * (x - self.space.first)])


def fit(
    problem: Problem,
    changes: Sequence[Change],
    train: Sequence[int],
    judge: Sequence[int],
    budget: int = 12,
    misfit: float = 1.0,
) -> Fit:
    """Fit changes jointly to the training motions and judge them on others.

    Args:
        problem: with its floors set.
        changes: with first guesses.
        train: cases to fit to.
        judge: cases to judge on.
        budget: iterations of the solver at most.
        misfit: the gap in floors that counts as noise, because no model comes closer.
    """
    if not any(c.free for c in changes):
        return Fit(list(changes), costs(problem, changes, [*train, *judge]))
    space = _Space(problem, changes)
    residual = _Residual(problem, space, train, misfit)
    before = residual(space.first)
    reach = 1.5 if misfit == 1.0 else OUTLIER
    scale = max(1.0, reach * float(np.sqrt(np.mean(before**2) * len(before) / len(train))))
    margin = scale / np.sqrt(_mean_length(problem, train))

    def solve(x: Array) -> OptimizeResult:
        return least_squares(
            residual,
            x,
            jac=residual.jacobian,
            bounds=space.bounds(),
            loss="soft_l1",
            f_scale=margin,
            max_nfev=budget,
            xtol=CLOSE,
            ftol=1e-4,
            gtol=1e-10,
        )

    def loss(x: Array) -> float:
        return float(margin**2 * np.sum(np.sqrt(1.0 + (residual(x) / margin) ** 2) - 1.0))

    solution = solve(space.first)
    for x in space.elsewhere(problem, solution.x):
        if loss(x) < BETTER * solution.cost:
            again = solve(x)
            solution = again if again.cost < solution.cost else solution
            break
    out = Fit(space.at(solution.x), names=space.names, value=solution.x * space.scale, misfit=misfit)
    fitted = dict(zip(train, residual.simulated(solution.x), strict=True))
    out.cost = {c: _mean_square(r) for c, r in fitted.items()} | costs(problem, out.changes, set(judge) - set(train))
    out.evaluations = len(residual.memo)
    return out


def costs(problem: Problem, changes: Sequence[Change], cases: Iterable[int]) -> dict[int, float]:
    """The mean squared residual of each case with a changed plant; 1 is the floor."""
    return {c: _mean_square(problem.residuals(changes, c)) for c in sorted(set(cases))}


def _mean_square(residual: Array) -> float:
    return float(np.mean(residual**2))


def _mean_length(problem: Problem, cases: Sequence[int]) -> float:
    return float(np.mean([problem.length(c) for c in cases]))


def _alike(residual: Array) -> Array:
    """A motion's residual so that its squares sum to their mean: every motion counts alike, however long."""
    return np.asarray(residual / np.sqrt(len(residual)))


def _differences(function: Callable[[Array], Array], x: Array, space: _Space) -> Array:
    base, high = function(x), space.bounds()[1]
    out = np.empty((len(base), len(x)))
    for k in range(len(x)):
        step = space.step * max(abs(x[k]), 0.3)
        if x[k] + step > high[k]:
            step = -step
        moved = x.copy()
        moved[k] += step
        out[:, k] = (function(moved) - base) / step
    return out


def assess(problem: Problem, result: Fit, train: Sequence[int], judge: Sequence[int]) -> Fit:
    """A fit with standard deviations and with what each motion alone would say of its values."""
    space = _Space(problem, result.changes)
    out = replace(result, names=space.names, value=space.first * space.scale)
    cases = sorted({*train, *judge})
    p = len(space.first)
    normal = np.zeros((p, p))
    out.step_per_case, out.weight_per_case = np.zeros((len(cases), p)), np.zeros((len(cases), p))
    for row, c in enumerate(cases):
        level = problem.levels(c, result.misfit)

        def coarse(y: Array, c: int = c, level: Array = level) -> Array:
            return level * problem.coarse_residuals(space.at(y), c)

        base = level * problem.residuals(result.changes, c)
        slope = _differences(coarse, space.first, space)
        robust = 1.0 / np.sqrt(1.0 + (base / (OUTLIER * max(1.0, np.sqrt(out.cost[c])))) ** 2)
        gradient, curvature = slope.T @ (robust * base), (slope * robust[:, None]).T @ slope
        out.step_per_case[row] = -gradient / np.maximum(np.diag(curvature), 1e-30) * space.scale
        out.weight_per_case[row] = np.diag(curvature) / space.scale**2
        if c in train:
            inflation = max(float(np.mean(base**2)), 1.0) * _correlation_time(base, len(problem.cases[c].measured.time))
            normal += curvature / inflation
    covariance = np.linalg.pinv(normal + 1e-12 * np.eye(p) * max(float(np.trace(normal)), 1e-30))
    out.deviation = np.sqrt(np.maximum(np.diag(covariance), 0.0)) * space.scale
    return out


def _correlation_time(residual: Array, samples: int) -> float:
    """How many samples of a residual count as one: the integrated autocorrelation, at least 1."""
    r = residual - residual.mean()
    power = float(r @ r)
    if power <= 0:
        return 1.0
    reach = min(samples // 4, 200)
    total = 1.0
    for lag in range(1, reach):
        rho = float(r[:-lag] @ r[lag:]) / power
        if rho < 0.05:
            break
        total += 2.0 * rho
    return total
