"""The values that a fit moves, as one vector: their scales, bounds and priors."""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy

import numpy as np

from realitygap.diagnose.candidates.suspects import bounds, neutral, sizes, whole
from realitygap.diagnose.data.changes import Change
from realitygap.diagnose.data.problem import Problem
from realitygap.robot.drive import Array

STEP, CONTACT_STEP = 0.05, 0.15
"""Step of a numerical derivative, as a part of the parameter's size: of a robot that is bolted down, and of a free
body, where contacts that come and go make small differences tell nothing but that."""
LITTLE = 0.3
"""A value that is less than this part of its size is moved as far as one that is this part of it."""
TURNED = 0.3
"""How far a wave is turned by that step at most, where the joint was furthest from zero [rad]."""
SLAB = 4.0
"""Prior width of a named value about the model's own, in visible first sizes: a try at one size is to be neither
negligible nor absurd."""
LOOSE = 10.0
"""The same for shapes and stiffnesses, about their first guess."""
TAIL = 1.5
"""Priors are normal up to so many widths, and have room for what is far wrong beyond (a power law, as smooth): a horn
that is mounted a tooth or two further is off by 0.25 or 0.5 rad, 3 or 6 widths. Where priors were normal throughout 0.5
rad cost 19 in evidence, and a centre of mass had the name. With Cauchy's in their place an STS3215, whose first round
hangs on little, was left at 0.068 rad, and not at 0.029."""
LEAST = 1e-6
"""A positive quantity is at least this many of its sizes."""


def negative_log_prior(far: Array) -> Array:
    """The negative log prior density, beside a constant, of values so many widths from where they are expected."""
    beyond = np.maximum(np.abs(far) / TAIL, 1.0)
    return np.asarray(0.5 * np.minimum(np.abs(far), TAIL) ** 2 + TAIL**2 * np.log(beyond))


class Space:
    """The fitted values of several changes as one vector, scaled by their sizes."""

    def __init__(self, problem: Problem, changes: Sequence[Change]) -> None:
        self.changes = list(changes)
        names, scale, low, high, first, expected, width, positive, furthest = [], [], [], [], [], [], [], [], []
        for i, change in enumerate(self.changes):
            size, zero = sizes(problem.plant, change.suspect), neutral(problem.plant, change.suspect)
            within = bounds(problem.plant, change.suspect)
            for name in change.free:
                p, value = change.suspect.kind.parameter(name), change.parameters[name]
                names.append((i, name))
                plain = np.isfinite(zero[name]) and not p.shape and not whole(change.suspect.kind)
                scale.append(max(size[name] if plain or value == 0.0 else abs(value), p.typical, 1e-12))
                expected.append(zero[name] if plain else value)
                width.append(SLAB if plain else LOOSE)
                positive.append(plain and p.absent is None and p.low >= 0.0 and zero[name] > 0.0)
                low.append(within[name][0])
                high.append(within[name][1])
                first.append(min(max(value, low[-1]), high[-1]))
                furthest.append(TURNED / _reach(problem, change) if name == "periods" else np.inf)
        self.names = tuple(names)
        self.scale, self.low, self.high = np.array(scale), np.array(low), np.array(high)
        self.first = np.array(first) / self.scale
        self.expected, self.width = np.array(expected) / self.scale, np.array(width)
        self.positive = np.array(positive, dtype=bool)
        self.furthest = np.array(furthest) / self.scale
        self.step = CONTACT_STEP if problem.plant.model.floating else STEP

    def wide(self) -> Space:
        """The same values with derivatives over what is rough, as of a free body.

        Play makes a likelihood of fine recordings pitted: of a joint with 0.01 rad of it a fit ended at 0.0088, 11,000
        in evidence below the best, where steps of 5 % lead to worse places and those of 15 % lead out.
        """
        other = copy(self)
        other.step = CONTACT_STEP
        return other

    def bounds(self) -> tuple[Array, Array]:
        """Lower and upper bounds of the scaled values."""
        return self.low / self.scale, self.high / self.scale

    def prior(self, x: Array) -> Array:
        """A pseudo-residual for each scaled value, half of whose square is its negative log prior. Shape (p,).

        The logarithm of a quantity that is there and positive counts: a tenth of a mass is as odd as its tenfold.
        """
        far = self._far(x)
        return np.asarray(np.sign(far) * np.sqrt(2.0 * negative_log_prior(far)))

    def prior_slope(self, x: Array) -> Array:
        """The derivative of that. Shape (p,)."""
        far = np.maximum(np.abs(self._far(x)), LEAST)  # the same on both sides
        bent = np.minimum(far, TAIL**2 / far) / np.sqrt(2.0 * negative_log_prior(far))
        own = np.where(self.positive, self.expected / np.maximum(x, LEAST), 1.0) / self.width
        return np.asarray(own * bent)

    def _far(self, x: Array) -> Array:
        """How far scaled values are from where their priors expect them, in widths. Shape (p,)."""
        ratio = np.where(self.positive, np.maximum(x, LEAST) / np.where(self.positive, self.expected, 1.0), 1.0)
        far = np.where(self.positive, self.expected * np.log(ratio), x - self.expected)
        return np.asarray(far / self.width)

    def with_prior(self, x: Array, white: Array, unit: Array | float = 1.0) -> Array:
        """Whitened slopes and residual, augmented by rows of what priors say. Shape (r, p + 1) -> (r + p, p + 1).

        Args:
            x: the scaled values.
            white: the Jacobian of the whitened residual per unit of each value, and the residual.
            unit: of the values. Shape (p,) or one for all.
        """
        prior = np.column_stack([np.diag(self.prior_slope(x) * unit), self.prior(x)])
        return np.vstack([white, prior])

    def at(self, x: Array) -> tuple[Change, ...]:
        """The changes at scaled values."""
        values: list[dict[str, float]] = [{} for _ in self.changes]
        for (i, name), v, low, high in zip(self.names, x * self.scale, self.low, self.high, strict=True):
            values[i][name] = float(min(max(v, low), high))
        return tuple(c.at(v) for c, v in zip(self.changes, values, strict=True))

    def unit(self, x: Array) -> Array:
        """How far each scaled value is moved for a derivative. Shape (p,)."""
        return np.asarray(np.minimum(self.step * np.maximum(np.abs(x), LITTLE), self.furthest))

    def steps(self, x: Array) -> list[tuple[Array, float]]:
        """A moved vector for every value, and how far it moved."""
        out = []
        high = self.bounds()[1]
        for k, step in enumerate(self.unit(x).tolist()):
            if x[k] + step > high[k]:
                step = -step
            moved = x.copy()
            moved[k] += step
            out.append((moved, step))
        return out


def _reach(problem: Problem, change: Change) -> float:
    """The furthest from zero that the joints of a change were in training [rad or m]."""
    seen = [problem.cases[c].value("position")[:, list(change.suspect.indices)] for c in problem.of("train")]
    return max(float(np.nanmax(np.abs(q), initial=1e-12)) for q in seen)
