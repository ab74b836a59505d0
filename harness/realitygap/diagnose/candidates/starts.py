"""Starts: how a suspect is tried before it is fitted, and what a multiple of each try means.

A start is a list of tries, each a change at a visible size: the response of the traces to a try, times an amount, is
what the effect is taken to do until it is simulated there. A visible size, because the derivative of backlash, stiction
and stops at zero is zero.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from realitygap.diagnose.candidates.ripple import ORDINARY, periods_of
from realitygap.diagnose.candidates.suspects import bounds, fitted, neutral, sizes, whole
from realitygap.diagnose.data.changes import Change, Suspect
from realitygap.diagnose.data.problem import Problem
from realitygap.robot.drive import Array
from realitygap.robot.effects import Effect, Parameter
from realitygap.robot.effects.joint import seen_periods

WHOLE_FIRST = (3.2, 1.6, 0.8, 0.4)
WHOLE_SECOND = (1.0, 1.6, 2.5)
"""What the first sizes are multiplied by for effects whose parameters only mean something together."""
SOFTER = (1.0, 0.3, 0.1)
"""What the first size of a limit or a stiffness is multiplied by: a soft one does what no straight line tells."""
SWINGS = tuple(0.8**k for k in range(11))
"""The same of a spring that lets its link swing: the next frequency is a ninth away. Of one of 41 N·m/rad a pendulum's
recordings are more probable with 38 to 50, and less so with what is softer or harder than they are without."""
SLIPPERIER = (0.6, 0.3, 0.15)
"""What the friction of the ground is multiplied by: what does not slip yet shows nothing, as no straight line tells."""
TO_BOTH_SIDES = (1.0, -1.0)
"""What the first size is multiplied by where it may have either sign: play and friction that holds answer unevenly."""
NEARBY = 0.3
"""The share of a first size that is simulated where the model has more than that of it, as of a mass or a constant:
some per cent, as far as laws are off without being wrong. What is absent, or acts through contacts that come and go,
shows only at a visible size."""
FURTHEST = 12.0
"""How many first sizes a straight line is followed at most."""
LIGHTEST = 0.05
"""A load whose point masses, or a spring whose parts, add up to less than this many of their first sizes is taken as so
much: it has no centre."""
SHORTEST = 0.05
"""How far from its link's frame a load is tried at least [m]."""
NARROWEST = 0.1
"""How far from zero a spring's rest is tried at least [rad or m]."""
PERIODS = (2.0, 5.0, 12.0)
"""Periods of a ripple that are tried where no residual shows any."""


@dataclass(frozen=True)
class Start:
    """Tries of one suspect, and what amounts of them mean.

    Attributes:
        first: the suspect at its first guess, with what is fitted later.
        tries: changes at a visible size.
        zero: the neutral values.
        kind: `linear`: a parameter moves from neutral by the amount; `inverse`: a stiffness, twice as much is half of
            it; `whole`: as it is or not at all; `wave`: two tries are sine and cosine of one wave; `centre`: masses at
            several places, or springs that rest at several angles, whose sum is one at their centre.
        share: of each try that is simulated; the response is taken as many times.
        within: the least and the largest value of each parameter at the target, of a linear start.
    """

    first: Change
    tries: tuple[Change, ...]
    zero: tuple[tuple[str, float], ...]
    kind: Literal["linear", "inverse", "whole", "wave", "centre"]
    share: float = 1.0
    within: tuple[tuple[str, tuple[float, float]], ...] = ()

    @property
    def suspect(self) -> Suspect:
        """Whose start it is."""
        return self.first.suspect

    def moved(self, number: int) -> list[str]:
        """The parameters that a try moves away from neutral."""
        zero, values = dict(self.zero), self.tries[number].parameters
        return [p.name for p in sized(self.first) if values[p.name] != zero[p.name]]

    @property
    def stiffness(self) -> float:
        """Of a try of one limit or stiffness, its value."""
        (name,) = self.moved(0)
        return self.tries[0].parameters[name]

    def simulated(self, number: int) -> Change:
        """What is simulated for a try: `share` of it."""
        zero, try_ = dict(self.zero), self.tries[number]
        if self.share == 1.0:
            return try_
        return try_.at({n: zero[n] + self.share * (try_.parameters[n] - zero[n]) for n in self.moved(number)})

    def at(self, amounts: Sequence[float]) -> Change:
        """The change that amounts of the tries mean, within the bounds of its parameters."""
        if self.kind == "whole":
            return self.tries[0]
        if self.kind == "wave":
            sine, cosine = amounts
            (wave,) = sized(self.first)
            size = self.tries[0].parameters[wave.name] * math.hypot(sine, cosine)
            return self.tries[0].at({wave.name: min(size, wave.high), "phase": math.atan2(cosine, sine)})
        zero, values = dict(self.zero), {}
        if self.kind == "centre":
            (weight,) = (p.name for p in sized(self.first))
            total = max(sum(amounts), LIGHTEST)
            shares = [(a, t.parameters) for a, t in zip(amounts, self.tries, strict=True)]
            place = {n: sum(a * at[n] for a, at in shares) / total for n in self.first.free if n != weight}
            place = {n: float(np.clip(value, *self._within(n))) for n, value in place.items()}
            return self.first.at({weight: total * self.tries[0].parameters[weight], **place})
        for k, amount in enumerate(amounts):
            for name in self.moved(k):
                (low, high), tried = self._within(name), self.tries[k].parameters[name]
                value = (
                    tried / max(amount, 1e-3) if self.kind == "inverse" else zero[name] + amount * (tried - zero[name])
                )
                values[name] = float(np.clip(value, low, high))
        return self.first.at(values)

    def reach(self, number: int) -> tuple[float, float]:
        """The least and the largest amount of a try within the bounds of its parameters."""
        if self.kind == "whole":
            return 1.0, 1.0
        if self.kind in ("wave", "centre"):
            return -FURTHEST, FURTHEST
        if self.kind == "inverse":
            return 0.0, FURTHEST
        low, high, zero = -FURTHEST, FURTHEST, dict(self.zero)
        for name in self.moved(number):
            change = self.tries[number].parameters[name] - zero[name]
            a, b = sorted((end - zero[name]) / change for end in self._within(name))
            low, high = max(low, a), min(high, b)
        return min(low, 0.0), max(high, 0.0)

    def _within(self, name: str) -> tuple[float, float]:
        """The least and the largest value of a parameter."""
        p = self.suspect.kind.parameter(name)
        return dict(self.within).get(name, (p.low, p.high))


def guess(problem: Problem, suspect: Suspect) -> Change:
    """A suspect at a first guess: its neutral value plus a sensible size; what is fitted later, if at all, as it is."""
    effect = suspect.kind
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
            values[p.name] = zero[p.name]
    return Change(suspect, tuple(values.items()), free)


def starts(problem: Problem, suspect: Suspect, residual: Sequence[Array] = ()) -> list[Start]:
    """The starts of a suspect.

    Args:
        problem: the motions.
        suspect: what is tried.
        residual: of every training motion, of the suspect's joint by signal, for what shows in a spectrum: (t, k).
    """
    effect = suspect.kind
    zero = neutral(problem.plant, suspect)
    size = sizes(problem.plant, suspect)
    first = guess(problem, suspect)
    known = tuple(zero.items())
    if {"lower", "upper"} <= set(first.free):
        return [Start(t, (t,), known, "whole") for t in _stops(problem, first)]
    if whole(effect):
        one, two = first.free[:2]
        grid = [(a, b) for a in WHOLE_FIRST for b in WHOLE_SECOND]
        tries = [first.at({one: first.parameters[one] * a, two: first.parameters[two] * b}) for a, b in grid]
        return [Start(first, (t,), known, "whole") for t in tries]
    if {"mass", "x", "y", "z"} <= set(first.free):
        arm = max(math.hypot(*(size[n] for n in "xyz")), SHORTEST)
        ends = {n: math.copysign(arm, first.parameters[n]) for n in "xyz"}  # a link's mass lies where the link does
        at = [first.at({n: ends[n] * (n == axis) for n in "xyz"}) for axis in ("", "x", "y", "z")]
        return [Start(first, tuple(at), known, "centre")]
    if "periods" in first.free:
        train, joint = problem.of("train")[: len(residual)], suspect.indices[0]
        angles = [problem.cases[c].value("position")[:, joint] for c in train]
        highest = ORDINARY if effect.dissipative else effect.parameter("periods").high  # friction goes with a shaft
        waves = periods_of(angles, residual, highest) or _visible(problem, joint)
        return [Start(first, _wave(first, size, p), known, "wave") for p in waves]
    hard = [p.name for p in sized(first) if not np.isfinite(zero[p.name])]
    if hard:
        return [Start(limit, (t,), known, "inverse") for n in hard for limit, t in _softer(first, n, hard, zero)]
    if effect.name == "ground_friction" and zero["coefficient"] > 0:
        slippery = [first.at({"coefficient": zero["coefficient"] * k}) for k in SLIPPERIER]
        return [Start(first, (t,), known, "linear") for t in slippery]
    named, within = [p.name for p in sized(first)], bounds(problem.plant, suspect)
    still = {n: zero[n] for n in named}
    out = []
    for factor in TO_BOTH_SIDES if signed(effect) else (1.0,):
        group = []
        for n in named:
            step, (low, high) = factor * size[n], within[n]
            inside = low <= zero[n] + step <= high
            group.append(first.at(still | {n: zero[n] + (step if inside else -step)}))
        near = not problem.plant.model.floating and all(abs(zero[n]) >= size[n] for n in named)
        out.append(Start(first, tuple(group), known, "linear", NEARBY if near else 1.0, tuple(within.items())))
    if {"stiffness", "rest"} == set(zero) and not zero["stiffness"]:
        out.append(_elsewhere(problem, first, known))
    return out


def _elsewhere(problem: Problem, first: Change, known: tuple[tuple[str, float], ...]) -> Start:
    """A spring that rests anywhere: one at zero, and one as far away as its joint moved.

    By its stiffness alone one that rests elsewhere hardly shows: of 2 N·m/rad about 0.5 rad it promised 3 in evidence
    where both promise 292, and another centre of mass had the name.
    """
    moved = problem.plant.travelled
    away = 0.0 if moved is None else float(moved[first.suspect.indices[0]])
    angle = max(away, NARROWEST)
    tries = (first.at({"rest": 0.0}), first.at({"rest": angle}))
    return Start(replace(first, free=("stiffness", "rest")), tries, known, "centre")


def _softer(first: Change, name: str, hard: Sequence[str], zero: Mapping[str, float]) -> list[tuple[Change, Change]]:
    """One limit or stiffness alone, the others as if there were none: the first guess, and a try of several sizes."""
    others = [n for n in hard if n != name]
    alone = replace(first.at({n: zero[n] for n in others}), free=tuple(n for n in first.free if n not in others))
    shares = SWINGS if swings(first.suspect) else SOFTER
    return [(alone, alone.at({name: first.parameters[name] * k})) for k in shares]


def swings(suspect: Suspect) -> bool:
    """Whether it is a spring that lets its link swing."""
    kind = suspect.kind
    return kind.sits_at == "joint" and any(p.name == "damping" for p in kind.parameters)


def softer(start: Start) -> list[Start]:
    """Springs that are softer than that of a start, by as much as the first ones differ among each other."""
    (name,), (try_,) = start.moved(0), start.tries
    least = start.suspect.kind.parameter(name).low
    return [replace(start, tries=(try_.at({name: k}),)) for s in SWINGS[1:] if (k := s * start.stiffness) > least]


def signed(effect: Effect) -> bool:
    """Whether an effect is absent at zero and may have either sign."""
    return all(p.absent == 0.0 and p.low < 0.0 for p in fitted(effect))


def _visible(problem: Problem, joint: int) -> list[float]:
    return sorted({seen_periods(problem.plant, joint, periods) for periods in PERIODS})


def _wave(first: Change, size: Mapping[str, float], periods: float) -> tuple[Change, ...]:
    (wave,) = sized(first)
    return tuple(first.at({wave.name: size[wave.name], "periods": periods, "phase": p}) for p in (0.0, np.pi / 2))


def _stops(problem: Problem, first: Change) -> list[Change]:
    """A stop where the recorded motion turned at the latest, on either side alone."""
    joint, zero = first.suspect.indices[0], neutral(problem.plant, first.suspect)
    seen = np.concatenate([problem.cases[c].value("position")[:, joint] for c in problem.of("train")])
    ends = {"lower": float(np.nanmin(seen)), "upper": float(np.nanmax(seen))}
    out = []
    for end, angle in ends.items():
        other = "upper" if end == "lower" else "lower"
        out.append(replace(first.at({end: angle, other: zero[other]}), free=(end, "stiffness")))
    return out


def sized(change: Change) -> list[Parameter]:
    """The free parameters of a change that act on their own; the others only shape what these do."""
    return [p for p in change.suspect.kind.parameters if p.name in change.free and not p.shape]
