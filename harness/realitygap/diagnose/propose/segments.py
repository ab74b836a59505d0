"""Segments: pieces of motion that people run, each of which starts and ends at rest in one pose.

Because of that they can be put one behind the other in any order, and what each tells adds up.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from realitygap.diagnose.propose.limits import Limits
from realitygap.diagnose.propose.multisine import BANDS, FADE, LENGTH, PHASES, Multisine, drawn
from realitygap.robot.drive import Array
from realitygap.scenario.propose import SegmentKind

REST = 0.4
"""How long a segment rests in the pose before it ends [s]: several times what a servo's position loop needs."""
QUICK = 0.5
"""Share of the largest speed at which a joint is moved to where a segment has it."""
PEAK = 1.875
"""The largest speed of a smooth way is so many times its mean (minimum jerk, Flash & Hogan 1985)."""
USED = 0.8
"""Share of the largest speed that waves and triangles may ask for: a joint overshoots."""


@dataclass(frozen=True)
class Segment:
    """A piece of motion at the rate of the commands.

    Attributes:
        kind: what it is.
        label: for people, with its size.
        joints: those that move.
        value: commands [rad or m]. Shape (m, n).
        enabled: whether the servos of the joints that move are on. Shape (m,).
        maker: what made it.
        wave: of a multisine.
    """

    kind: SegmentKind
    label: str
    joints: tuple[int, ...]
    value: Array
    enabled: NDArray[np.bool_]
    maker: Builder
    wave: Multisine | None = None

    def commands(self) -> Array:
        """The commands, NaN where a servo is off. Shape (m, n)."""
        out = self.value.copy()
        for j in self.joints:
            out[~self.enabled, j] = np.nan
        return out


@dataclass(frozen=True)
class Builder:
    """Makes the segments along one direction: a joint, or several in step.

    Attributes:
        along: how far each joint goes [rad or m] by every unit of the way. Shape (n,).
        home: the pose in which segments start and end. Shape (n,).
        limits: what must not be left.
        period: of the commands [s].
        name: of the direction, where a robot has several.
        pace: the share of the largest speed that is used as if it was all of it: speed costs effort.
    """

    along: Array
    home: Array
    limits: Limits
    period: float
    name: str = ""
    pace: float = 1.0

    def every(self, kinds: Sequence[SegmentKind]) -> list[Segment]:
        """Segments of these kinds, each in several sizes and speeds."""
        makers = {
            "hold": self._holds,
            "triangle": self._triangles,
            "step": self._steps,
            "chirp": self._chirps,
            "multisine": self._multisines,
            "reversal": self._reversals,
            "release": self._releases,
        }
        return [segment for kind in kinds for segment in makers[kind]()]

    def stay(self) -> Segment:
        """At rest in the pose."""
        return self._segment("hold", "stays", [self._stay(0.0, REST)])

    @property
    def _ends(self) -> tuple[float, float]:
        """How far the way may go from home, down and up, with room for what a servo overshoots."""
        ends = np.sort(
            [(end - self.home)[self._moved] for end in (self.limits.lower, self.limits.upper)] / self._each, 0
        )
        return 0.9 * float(ends[0].max()), 0.9 * float(ends[1].min())

    @property
    def _moved(self) -> NDArray[np.bool_]:
        """Which joints move. Shape (n,)."""
        return np.asarray(self.along != 0.0)

    @property
    def _each(self) -> Array:
        """How far each joint that moves goes by every unit of the way."""
        return self.along[self._moved]

    @property
    def _fast(self) -> float:
        return self.pace * float(np.min(self.limits.speed[self._moved] / np.abs(self._each)))

    def _segment(self, kind: SegmentKind, label: str, parts: Sequence[Array], off: tuple[int, int] = (0, 0)) -> Segment:
        """Parts one behind the other, the last one back home and at rest. `off` is where the servo is off."""
        way = np.concatenate([*parts, self._to(parts[-1][-1], 0.0), np.zeros(self._ticks(REST))])
        value = self.home + way[:, None] * self.along
        enabled = np.ones(len(way), dtype=bool)
        enabled[slice(*off)] = False
        label = f"{label} of {self.name}" if self.name else label
        label = f"{label} at {self.pace:.0%} of the speed" if self.pace < 1.0 else label
        return Segment(kind, label, tuple(np.flatnonzero(self._moved).tolist()), value, enabled, self)

    def _ticks(self, seconds: float) -> int:
        return max(int(np.ceil(seconds / self.period - 1e-6)), 1)

    def _to(self, here: float, there: float) -> Array:
        """A smooth way (minimum jerk)."""
        ticks = self._ticks(PEAK * abs(there - here) / (QUICK * self._fast)) if there != here else 0
        x = np.arange(1, ticks + 1) / max(ticks, 1)
        return np.asarray(here + (there - here) * x**3 * (10 - 15 * x + 6 * x**2))

    def _stay(self, place: float, seconds: float) -> Array:
        return np.full(self._ticks(seconds), place)

    def _holds(self) -> Iterator[Segment]:
        low, high = self._ends
        for name, places in (
            ("from end to end", (low, 0.5 * low, 0.5 * high, high)),
            ("at one end", (0.5 * high, high)),
            ("at the other end", (0.5 * low, low)),
        ):
            parts, here = [], 0.0
            for place in places:
                parts += [self._to(here, place), self._stay(place, 0.8)]
                here = place
            yield self._segment("hold", f"holds {name}", parts)

    def _triangles(self) -> Iterator[Segment]:
        low, high = self._ends
        for reach, name in ((1.0, "wide"), (0.4, "narrow")):
            for share, pace in ((0.08, "slow"), (0.3, "brisk"), (USED, "fast")):
                a, b = reach * low, reach * high
                speed = share * self._fast
                lap = 2.0 * (b - a) / speed
                if lap > 8.0:
                    continue
                laps = max(1, int(2.5 / lap))
                corners = [0.0, *([b, a] * laps), 0.0]
                parts = [self._line(x, y, speed) for x, y in pairwise(corners)]
                yield self._segment("triangle", f"{name} {pace} triangle", [p for p in parts if len(p)])

    def _line(self, here: float, there: float, speed: float) -> Array:
        ticks = self._ticks(abs(there - here) / speed)
        return np.asarray(here + (there - here) * np.arange(1, ticks + 1) / ticks)

    def _steps(self) -> Iterator[Segment]:
        low, high = self._ends
        for reach, name in ((0.7, "large"), (0.3, "small"), (0.08, "tiny")):
            a, b = reach * low, reach * high
            places = (b, a, 0.5 * b, 0.5 * a, b, 0.0)
            yield self._segment("step", f"{name} steps", [self._stay(p, 0.6) for p in places])

    def _chirps(self) -> Iterator[Segment]:
        low, high = self._ends
        length = 3.0
        t = self.period * np.arange(1, self._ticks(length) + 1)
        for reach, name in ((0.6, "wide"), (0.2, "narrow")):
            size, middle = 0.5 * reach * (high - low), 0.5 * reach * (high + low)
            first, last = 0.2, min(USED * self._fast / (2 * np.pi * max(size, 1e-9)), 0.1 / self.period, 8.0)
            if last <= first:
                continue
            phase = 2 * np.pi * (first * t + 0.5 * (last - first) / length * t**2)
            fade = np.minimum(1.0, np.minimum(t, length - t) / 0.2)
            wave = self._wave(np.sin(phase) * fade, size)
            yield self._segment("chirp", f"{name} chirp to {last:.1f} Hz", [self._to(0.0, middle), middle + wave])

    def _wave(self, shape: Array, size: float) -> Array:
        """A shape of this size, or as large as the speed allows."""
        steepest = float(np.abs(np.diff(shape, prepend=0.0)).max())
        return np.asarray(shape * min(size / float(np.abs(shape).max()), USED * self._fast * self.period / steepest))

    def _multisines(self) -> Iterator[Segment]:
        for number in range(PHASES):
            random = np.random.default_rng(number)
            for name, band in BANDS.items():
                yield self.multisine(drawn(band, random), f"{name} multisine {number + 1}")

    def multisine(self, wave: Multisine, label: str) -> Segment:
        """A multisine about the middle of where the joint may go, as large as limits allow."""
        low, high = self._ends
        t = self.period * np.arange(1, self._ticks(LENGTH) + 1, dtype=float)
        fade = np.minimum(1.0, np.minimum(t, LENGTH - t) / FADE)
        middle = 0.5 * (low + high)
        shape = self._wave(wave.at(t) * fade, wave.size * 0.5 * (high - low))
        return replace(self._segment("multisine", label, [self._to(0.0, middle), middle + shape]), wave=wave)

    def _reversals(self) -> Iterator[Segment]:
        """Small triangles about places where the joint is loaded: play, spring and dry friction part there."""
        low, high = self._ends
        for end, name in ((high, "upper"), (low, "lower")):
            place, size = 0.7 * end, min(0.06 * (high - low), 0.3 * abs(end))
            corners = [place, *([place + size, place - size] * 3), place]
            parts = [self._line(x, y, 0.1 * self._fast) for x, y in pairwise(corners)]
            yield self._segment("reversal", f"small reversals at the {name} end", [self._to(0.0, place), *parts])

    def _releases(self) -> Iterator[Segment]:
        """Raised, let go, and caught again by a smooth way home from where the command was."""
        low, high = self._ends
        for place, name in ((0.6 * high, "upper"), (0.6 * low, "lower")):
            raised = np.concatenate([self._to(0.0, place), self._stay(place, 0.4)])
            free = np.zeros(self._ticks(1.6))  # when the servo is on again it is told to be at home
            off = (len(raised), len(raised) + len(free))
            yield self._segment("release", f"released from the {name} side", [raised, free], off)
