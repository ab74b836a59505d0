"""What a missing effort depends on: the functions of one or two variables that predict it where they were not fitted.

Functions of one variable, sums of two of them and functions of two together are fitted as penalised splines, each to
all parts of the recordings but one, and judged on that one (leave one motion out; of few motions, parts of their time).
A second variable is taken where it makes the prediction better on nearly all parts, and by more than `LEAST`.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from realitygap.missing.effort import BAND, MissingEffort
from realitygap.missing.fit import EffortSamples, Fitted, fit, nothing
from realitygap.missing.splines import spline
from realitygap.robot.effort_map import VARIABLES, Table
from realitygap.robot.law.effort_map import TURNING
from realitygap.scenario.schema import EffectSpec
from realitygap.trace.trace import Array

MOST_SAMPLES = 6000
"""Of all recordings together."""
MOTIONS, FOLDS, PARTS, BLOCK = 4, 8, 5, 1.0
"""Recordings from which on whole ones are left out, in so many parts; otherwise parts, and the length of their blocks
of time [s]."""
SLOW, RARELY = 0.02, 0.1
"""A joint is at rest below this share of its own speed; one that moves less often than this is fitted at rest, too."""
LEAST = 0.03
"""The share that a variable must explain to be told, and a second one beyond the first."""
MOSTLY = 0.7
"""The share of the parts on which it must."""
ALIKE = 0.02
"""Shares that differ by less cannot be told apart."""
TWICE, SOUGHT = 2.0, 1.5
"""Periods within the angles that were seen from which on a function repeats itself, and from which on they are sought:
a bend that is best told by fewer than two is no wave."""
WAVE = 0.003
"""The share of a function's variance that its wave makes at least: half of what a slow bend leaves may be noise. One of
0.05 N·m beside a spring of 0.3 N·m/rad has 0.013, and the noise of that spring 0.00002."""
RECORDED = "temperature"
"""What recordings may tell and no simulation knows: it is looked at, and is no variable of an `effort_map`."""
SOFT = 0.1
"""The share of the effort's variance that is added to every sample's: none counts ten times as much as the mean."""


@dataclass(frozen=True)
class Term:
    """A part of a missing effort as a function of one or two variables.

    Attributes:
        variables: their names.
        knots: for each, increasing.
        values: effort at the knots [N·m or N]; of two variables row by row.
        share: what it explains of the missing effort's variance, where it was not fitted.
        periods: per turn, where it is a function of the angle that repeats itself.
    """

    variables: tuple[str, ...]
    knots: tuple[tuple[float, ...], ...]
    values: tuple[float, ...]
    share: float
    periods: float | None = None

    def effect(self, joint: str) -> EffectSpec:
        """The effect of a scenario that adds it to a joint."""
        told = Table(self.variables, self.knots).parameters(self.values)
        return EffectSpec.model_validate({"effect": "effort_map", "target": joint, **told})

    @property
    def known(self) -> bool:
        """Whether a simulation knows what it depends on."""
        return set(self.variables) <= set(VARIABLES)


@dataclass(frozen=True)
class Shape:
    """What the missing effort of one joint depends on.

    Attributes:
        joint: its name.
        size: the root mean square of the missing effort [N·m or N].
        mean: its mean.
        terms: what it depends on, the largest share first; none where nothing known predicts it.
        share: what they explain together of its variance, where they were not fitted.
        noise: the share of its variance that the band explains.
        within: how often its band holds 0.
        rivals: other variables that predict it as well.
        judged: whether there were parts to judge on; a motion within one block of time has none.
    """

    joint: str
    unit: str
    size: float
    mean: float
    terms: tuple[Term, ...]
    share: float
    noise: float
    within: float
    rivals: tuple[tuple[str, ...], ...]
    judged: bool = True

    @property
    def effects(self) -> list[EffectSpec]:
        """The terms as effects of a scenario, of variables that a simulation knows."""
        return [term.effect(self.joint) for term in self.terms if term.known]


def shape_of(runs: Sequence[MissingEffort], joint: str) -> Shape:
    """What the missing effort of a joint depends on, over these recordings of one engine."""
    samples, mean, noise = samples_of(runs, joint)
    index = runs[0].joints.index(joint)
    effort = np.concatenate([r.effort[:, index] for r in runs])
    size = float(np.sqrt(np.mean(effort**2)))
    within = float(np.mean(np.abs(effort) < BAND * np.concatenate([r.error[:, index] for r in runs])))
    unit = "N" if runs[0].slides[index] else "N·m"
    if samples.folds < 2:
        return Shape(joint, unit, size, mean, (), 0.0, noise, within, (), judged=False)
    whole = nothing(samples)
    chosen, alone, rivals = _choose(samples, whole)
    if chosen is None:
        return Shape(joint, unit, size, mean, (), 0.0, noise, within, ())
    shares = _shares(chosen, alone, whole)
    terms = [_term(chosen, k, share, samples, mean if k == 0 else 0.0) for k, share in enumerate(shares)]
    terms.sort(key=lambda term: -term.share)
    return Shape(
        joint, unit, size, mean, tuple(terms), float(1 - chosen.mean_left / whole.mean()), noise, within, rivals
    )


def _choose(
    samples: EffortSamples, whole: Array
) -> tuple[Fitted | None, dict[str, Fitted], tuple[tuple[str, ...], ...]]:
    """The best sum of splines; all functions of one variable; and the other variables that predict as well."""
    known = [v for v in (*VARIABLES, RECORDED) if v in samples.columns and np.ptp(samples.columns[v]) > 0]
    alone = {v: fit(samples, [spline((v,), samples.columns)]) for v in known}
    pairs: dict[tuple[str, ...], Fitted] = {}
    for a, b in combinations(known, 2):
        own = [alone[v].penalties[0] for v in (a, b)]
        tried = [[own[0] * x, own[1] * y] for x, y in ((1, 1), (10, 1), (1, 10), (10, 10), (0.1, 0.1))]
        added = fit(samples, [alone[a].splines[0], alone[b].splines[0]], tried)
        crossed = fit(samples, [spline((a, b), samples.columns)])
        pairs[a, b] = crossed if _better(crossed.left, added.left, whole) else added
    chosen, left = None, whole
    for found in ({(v,): f for v, f in alone.items()}, pairs):
        best = min(found.values(), key=lambda f: f.mean_left, default=None)
        if best is not None and _better(best.left, left, whole):
            chosen, left = best, best.left
            alike = tuple(v for v, f in found.items() if f is not best and _alike(f, best, whole))
    return chosen, alone, alike if chosen is not None else ()


def _better(left: Array, other: Array, whole: Array) -> bool:
    """Whether a fit leaves clearly less than another: in the mean, and on most parts, however much each has to tell."""
    parts = (other - left) / whole
    return bool((other - left).mean() > LEAST * whole.mean() and np.mean(parts > LEAST) >= MOSTLY)


def _alike(one: Fitted, best: Fitted, whole: Array) -> bool:
    return bool(one.mean_left - best.mean_left < ALIKE * whole.mean())


def _shares(chosen: Fitted, alone: dict[str, Fitted], whole: Array) -> list[float]:
    """What each term explains: the stronger one what it does alone, the other what it adds."""
    total = float(1 - chosen.mean_left / whole.mean())
    if len(chosen.splines) == 1:
        return [total]
    own = [float(1 - alone[s.variables[0]].mean_left / whole.mean()) for s in chosen.splines]
    stronger = int(own[1] > own[0])
    share = min(max(own[stronger], 0.0), total)
    return [share, total - share] if stronger == 0 else [total - share, share]


def _term(chosen: Fitted, k: int, share: float, samples: EffortSamples, mean: float) -> Term:
    """A term with values that stay within what was seen; each is about 0 in the mean, and the first has the mean."""
    one, values = chosen.splines[k], chosen.values[k]
    if len(chosen.splines) > 1 and k == 0:  # what one gains in the mean the other loses
        values = values + np.average(chosen.splines[1].design(samples.columns) @ chosen.values[1])
    elif k == 1:
        values = values - np.average(one.design(samples.columns) @ values)
    seen = one.design(samples.columns) @ values
    values = np.clip(values, seen.min(), seen.max()) + mean
    periods = _periods(one.knots[0], values) if one.variables == ("angle",) else None
    knots = tuple(tuple(float(f"{x:.6g}") for x in row) for row in one.knots)
    return Term(one.variables, knots, tuple(float(f"{x:.5g}") for x in values), share, periods)


def _periods(angle: Array, values: Array) -> float | None:
    """How often a turn a function repeats itself, where one sine is most of what it has beside a slow bend."""
    grid = np.linspace(angle[0], angle[-1], 400)
    f = np.interp(grid, angle, values)
    x = np.linspace(-1, 1, len(grid))
    slow = np.stack([np.ones_like(x), x, x * x], axis=1)
    span = (grid[-1] - grid[0]) / (2 * np.pi)
    best, found = np.inf, 0.0
    bent = np.sum((f - slow @ np.linalg.lstsq(slow, f, rcond=None)[0]) ** 2)
    for per_turn in np.arange(SOUGHT / span, 60.0, 0.02 / span):
        waves = np.stack([np.sin(per_turn * grid), np.cos(per_turn * grid)], axis=1)
        matrix = np.hstack([slow, waves])
        left = np.sum((f - matrix @ np.linalg.lstsq(matrix, f, rcond=None)[0]) ** 2)
        if left < best:
            best, found = float(left), float(per_turn)
    wave = best < 0.5 * bent and bent - best > WAVE * np.sum((f - f.mean()) ** 2)
    return found if wave and found >= TWICE / span else None


def samples_of(runs: Sequence[MissingEffort], joint: str) -> tuple[EffortSamples, float, float]:
    """The samples of all recordings, the mean effort, and the share of its variance that the band explains.

    At rest dry friction holds whatever is asked of it, which nothing that is measured tells: what moves is fitted.
    """
    j = runs[0].joints.index(joint)
    every = max(1, round(sum(len(r.time) for r in runs) / MOST_SAMPLES))
    common = set.intersection(*(set(r.variables) for r in runs))
    effort, error, time, run = (
        np.concatenate(parts)
        for parts in zip(
            *(
                (
                    r.effort[::every, j],
                    r.error[::every, j],
                    r.time[::every] - r.time[0],
                    np.full(len(r.time[::every]), i),
                )
                for i, r in enumerate(runs)
            ),
            strict=True,
        )
    )
    columns = {v: np.concatenate([r.variables[v][::every, j] for r in runs]) for v in common}
    if len(runs) >= MOTIONS:
        fold = run * min(len(runs), FOLDS) // len(runs)  # repetitions stand beside one another
    else:
        fold = (np.floor(time / max(BLOCK, time.max() / 40)) + run) % PARTS
    speed = np.abs(columns["speed"])
    moves = speed > max(TURNING, SLOW * float(np.quantile(speed, 0.99)))
    keep = moves if moves.mean() > RARELY else np.ones_like(moves)
    effort, error = effort[keep], error[keep]
    weight = 1 / (error**2 + SOFT * effort.var() + np.finfo(float).tiny)
    mean = float(np.average(effort, weights=weight))
    noise = float(min(np.average(error**2, weights=weight) / np.average((effort - mean) ** 2, weights=weight), 1.0))
    parts = np.unique(fold[keep], return_inverse=True)[1]
    return (
        EffortSamples(effort - mean, weight / weight.mean(), {v: x[keep] for v, x in columns.items()}, parts),
        mean,
        noise,
    )
