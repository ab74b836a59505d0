"""Fitting changes in simulation: bounded least squares in the metric of the residuals, with few derivatives.

The maximum a posteriori estimate, by Gauss-Newton steps within a trust region, a box that grows and shrinks with its
success (Moré 1983). The Jacobian, what the values do to the traces, is updated by secants (Broyden 1965) and simulated
anew only where a step does not do what was predicted: a derivative costs as many simulations as there are values, a
step costs one. Of many values it is taken along the axes of the fit (`axes`). A whole fit ends with the derivatives of
where it is; one that only has to be compared takes what it can from a fitted model near by, and a quick one stops
early.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from realitygap.diagnose.candidates.suspects import bounds, neutral
from realitygap.diagnose.data.changes import Change
from realitygap.diagnose.fit.axes import along_axes
from realitygap.diagnose.fit.bounded import bounded
from realitygap.diagnose.fit.motions import Motions
from realitygap.diagnose.fit.responses import at_once, own_joint, single
from realitygap.diagnose.fit.space import Space
from realitygap.diagnose.likelihood.metric import Metric
from realitygap.diagnose.likelihood.whitening import Channel
from realitygap.robot.drive import Array

STEPS, FEW = 16, 2
"""Steps of a fit at most, and of a quick one."""
FIRST = 2.0
"""How far a first step goes at most, in multiples of the values."""
AWAY = 0.5
"""The same of a value that is about zero, in its size."""
TRUE, FALSE = 0.75, 0.25
"""A step that gains this share of what it promised may be followed by a longer one, or was too long (Moré 1983)."""
SHORTER = 0.4
"""How much shorter the step is that follows one that was too long."""
CHEAP, PATIENCE = 8, 2
"""Derivatives are simulated anew where a step fails: at once where there are fewer values than this, for then they cost
little more than a step. With more, so many shorter steps are tried, and a fit that is only compared ends there: the
metric moves with it, and tells more than derivatives do until it has settled."""
TINY = 1e-12
"""A box has an inside."""
LITTLE = 0.2
"""A gain in evidence that no judgement hangs on."""
SILENT = 0.1
"""What a value changes the residual by, in standard deviations of all samples together, for it to be seen at all."""


Care = Literal["quick", "compared", "whole"]
"""How carefully values are fitted."""


@dataclass(frozen=True)
class Fit:
    """Fitted changes: a maximum a posteriori estimate, with the Jacobian there.

    Attributes:
        changes: with their values.
        names: (number of the change, parameter) of every fitted value.
        residual: stacked, of the training motions. Shape (m,).
        slope: the Jacobian: change of the residual per size of each value. Shape (m, p).
        size: of every value, in its unit. Shape (p,).
        prior: how far each value is from where its prior expects it, in standard deviations. Shape (p,).
        here: whether the slope is of these values, not of others near by, and what each does is told by all samples.
    """

    changes: tuple[Change, ...]
    residual: Array
    names: tuple[tuple[int, str], ...] = ()
    slope: Array = field(default_factory=lambda: np.zeros((0, 0)))
    size: Array = field(default_factory=lambda: np.zeros(0))
    prior: Array = field(default_factory=lambda: np.zeros(0))
    here: bool = True

    @property
    def value(self) -> Array:
        """The fitted values. Shape (p,)."""
        return np.array([self.changes[i].parameters[name] for i, name in self.names])


def fit(
    motions: Motions,
    changes: Sequence[Change],
    metric: Metric,
    known: Fit | None = None,
    care: Care = "whole",
    anew: bool = False,
) -> Fit | None:
    """Fit changes jointly to motions; None where they cannot be simulated.

    Args:
        motions: to fit to.
        changes: with first guesses.
        metric: of the stacked residual.
        known: a fitted model that shares values with the changes: what these do is taken from it at first.
        care: `quick` takes `FEW` steps and no derivative anew of what is known, `compared` takes them where a step
            fails and there are few values, `whole` ends with those of where it is.
        anew: whether to begin with derivatives of where it is.
    """
    space = Space(motions.problem, changes)
    quick, whole = care == "quick", care == "whole"
    full = motions.residual(changes) if whole or known is None else None
    near = known if full is None else Fit(tuple(changes), full)
    now = None if near is None else residual_near(motions, near, changes)
    if near is None or now is None:
        return None
    bolted = at_once(motions.problem) and not motions.problem.plant.model.floating
    own = metric.whitening.channels if bolted and not whole else None
    x, many, failed = space.first, len(space.first) >= CHEAP, 0
    slopes, here = _slopes(motions, None if anew and not many else known, space, own)
    if anew and many:
        slopes, here = along_axes(motions, space, x, now, slopes, metric, own), True
    cost, box = _cost(metric, space, x, now), FIRST
    patience, wide = PATIENCE if many else 0, many or quick or motions.problem.plant.model.floating
    for _ in range(FEW if quick else STEPS if len(x) else 0):
        step, predicted = _step(metric, space, x, now, slopes, box)
        if predicted >= 2.0 * LITTLE:
            there = residual_near(motions, near, space.at(x + step))
            gain = cost - _cost(metric, space, x + step, there) if there is not None else -np.inf
            good, went = gain > FALSE * predicted, float(np.max(np.abs(step) / np.maximum(np.abs(x), AWAY)))
            box = 2.0 * box if gain > TRUE * predicted else box if good else SHORTER * min(box, went)
            if there is not None and good:
                slopes, here = slopes + secant(slopes, step, there - now), False
            if there is not None and gain > 0.0:
                x, now, cost, here = x + step, there, cost - gain, False
            failed = 0 if good else failed + 1
            if good or quick or failed <= patience:
                continue
        elif here or not (whole or failed):
            break
        if many and not whole:
            break
        if not here:
            slopes = along_axes(motions, space, x, now, slopes, metric, own) if many else slope(motions, space, x, own)
            here = True
            box, failed = box / SHORTER ** max(failed - 1, 0), 0
        elif not wide:  # a step that derivatives of here do not tell: it is rough
            slopes, wide = slope(motions, space.wide(), x, own), True
            box, failed = FIRST, 0
    if whole:
        slopes, here = slopes if here else slope(motions, space, x), True
        now = motions.residual(space.at(x))
    alone = here and own is None
    return None if now is None else Fit(space.at(x), now, space.names, slopes, space.scale, space.prior(x), alone)


def stretched(motions: Motions, before: Sequence[Change], found: Fit, times: float) -> Fit | None:
    """A fit extrapolated that many times as far from where it began; None where that cannot be simulated."""
    space = Space(motions.problem, found.changes)
    began = np.array([before[i].parameters[name] for i, name in space.names]) / space.scale
    low, high = space.bounds()
    x = np.clip(began + times * (space.first - began), low, high)
    there = residual_near(motions, found, space.at(x))
    if there is None:
        return None
    return replace(found, changes=space.at(x), residual=there, prior=space.prior(x), here=False)


def resized(motions: Motions, found: Fit, times: float) -> Fit | None:
    """A fit with that many times as much of its last change; None where that has no size, or cannot be simulated."""
    if not found.changes:
        return None
    *rest, last = found.changes
    plant, kind = motions.problem.plant, last.suspect.kind
    zero, within = neutral(plant, last.suspect), bounds(plant, last.suspect)
    sized = [n for n in last.free if np.isfinite(zero[n]) and not kind.parameter(n).shape]
    sizes = {n: zero[n] + times * (last.parameters[n] - zero[n]) for n in sized}
    other = last.at({n: float(np.clip(v, *within[n])) for n, v in sizes.items()})
    there = residual_near(motions, found, [*rest, other]) if sized else None
    return None if there is None else replace(found, changes=(*rest, other), residual=there, here=False)


def as_seen(motions: Motions, found: Fit, metric: Metric) -> Fit:
    """A fit of which every value that could as well be that of the scenario's model is it: a centre of mass along the
    axis of the only hinge stays where it was, and a load there lies at its link's frame, whatever numerics made of it.
    Its slope is none. What does nothing by any of its values stays as it is.

    Args:
        motions: that it was fitted to.
        found: the fit.
        metric: whose whitening says what is seen.
    """
    own, tried = [i for i, _ in found.names], list[tuple[int, dict[str, float]]]()
    for k, (i, name) in enumerate(found.names):
        suspect = found.changes[i].suspect
        zero, parameter = neutral(motions.problem.plant, suspect)[name], suspect.kind.parameter(name)
        away = np.isfinite(zero) and found.changes[i].parameters[name] != zero
        if own.count(i) > 1 and away and (parameter.typical or not parameter.shape):
            tried.append((k, {name: zero}))
    if not tried:
        return found
    models = [[c.at(values) if j == own[k] else c for j, c in enumerate(found.changes)] for k, values in tried]
    still, *answers = motions.residuals([found.changes, *models])
    silent = {
        k: values
        for (k, values), answer in zip(tried, answers, strict=True)
        if still is not None and answer is not None and metric.seen(answer - still) < SILENT
    }
    slope, changes = found.slope.copy(), list(found.changes)
    for k, values in silent.items():
        if any(i == own[k] and j not in silent for j, i in enumerate(own)):
            changes[own[k]] = changes[own[k]].at(values)
            slope[:, k] = 0.0
    return replace(found, changes=tuple(changes), slope=slope)


def residual_near(motions: Motions, near: Fit, changes: Sequence[Change]) -> Array | None:
    """The stacked residual of changes: that of a fit near by, and the difference that coarse steps tell. Shape (m,)."""
    there, here = motions.residuals([changes, near.changes])
    return None if there is None or here is None else near.residual + there - here


def _step(metric: Metric, space: Space, x: Array, residual: Array, slopes: Array, box: float) -> tuple[Array, float]:
    """The Gauss-Newton step within the trust region and the bounds, and the reduction of the cost that it predicts."""
    white = space.with_prior(x, metric(np.column_stack([slopes, residual])))
    low, high = space.bounds()
    reach = box * np.maximum(np.abs(x), AWAY)
    step = nearest(white, np.maximum(low - x, -reach), np.minimum(high - x, reach))
    return step, float(np.sum(white[:, -1] ** 2) - np.sum((white[:, -1] + white[:, :-1] @ step) ** 2))


def nearest(white: Array, low: Array, high: Array) -> Array:
    """Bounded least squares: the amounts of all columns but the last that take most away from that one.

    By a QR decomposition. (r, p + 1) -> (p,).
    """
    triangle = np.asarray(np.linalg.qr(white, mode="r"))
    step = bounded(triangle[:-1, :-1], -triangle[:-1, -1], low - TINY, high + TINY)
    return np.asarray(np.clip(step, low, high))


def secant(slopes: Array, step: Array, change: Array) -> Array:
    """Broyden's rank-one update (1965): what is added to slopes for them to tell what a step changed, and as they did
    across it.
    """
    return np.asarray(np.outer(np.nan_to_num(change) - slopes @ step, step / (step @ step)))


def _cost(metric: Metric, space: Space, x: Array, residual: Array) -> float:
    """Minus twice the logarithm of the posterior density, beside a constant."""
    return float(np.sum(metric(residual) ** 2) + np.sum(space.prior(x) ** 2))


def _slopes(motions: Motions, known: Fit | None, space: Space, own: Sequence[Channel] | None) -> tuple[Array, bool]:
    """The Jacobian per scaled value at the first guess, (m, p), and whether all of it is of there.

    What is known is taken as it is, what is new is simulated.
    """
    have = {} if known is None else {(known.changes[i].suspect, name): k for k, (i, name) in enumerate(known.names)}
    places = [have.get((space.changes[i].suspect, name)) for i, name in space.names]
    new = [k for k, place in enumerate(places) if place is None]
    fresh = slope(motions, space, space.first, own, new)
    slopes = np.zeros((len(fresh), len(places)))
    slopes[:, new] = fresh
    if known is None or len(new) == len(places):
        return slopes, True
    old = [k for k, place in enumerate(places) if place is not None]
    at = [place for place in places if place is not None]
    slopes[:, old] = known.slope[:, at] * (space.scale[old] / known.size[at])
    return slopes, known.here and set(space.changes) == set(known.changes)


def slope(
    motions: Motions,
    space: Space,
    x: Array,
    own: Sequence[Channel] | None = None,
    values: Sequence[int] | None = None,
) -> Array:
    """The Jacobian of the stacked residual per scaled value, by finite differences, simulated side by side. (m, p).

    Args:
        motions: that are simulated.
        space: of the values.
        x: where.
        own: the channels of the residual, where the same value of one effect is moved at all joints at once and each
            joint's answer is its own, as responses are. For fits of a robot that is bolted down which are only
            compared: on the SO-101 the cosine with the slope of the value alone is 0.97 to 1; on a humanoid it is 0.02
            to 0.97, since one joint's friction moves all of it. None for each value alone.
        values: the numbers of the values that count; None for all.
    """
    steps = space.steps(x)
    counted = range(len(steps)) if values is None else values
    alike: dict[object, list[int]] = {}
    for k in counted:
        i, name = space.names[k]
        suspect = space.changes[i].suspect
        alike.setdefault((suspect.effect, name) if own is not None and single(suspect) else k, []).append(k)
    moved = [x + np.sum([steps[k][0] - x for k in group], axis=0) for group in alike.values()]
    still, *answers = motions.residuals([space.at(y) for y in [x, *moved]])
    if still is None:
        still = motions.residual(space.at(x))
        assert still is not None
    slopes = np.zeros((len(still), len(steps)))
    for group, answer in zip(alike.values(), answers, strict=True):
        change = np.zeros(len(still)) if answer is None else np.nan_to_num(answer - still)
        for k in group:
            slopes[:, k] = change / steps[k][1]
            if own is not None and len(group) > 1:
                (joint,) = space.changes[space.names[k][0]].suspect.indices
                slopes[~own_joint(motions.problem, own, joint), k] = 0.0
    return slopes[:, list(counted)]
