"""Law discrepancy: how far the laws of a model may be off without anything being missing.

The model discrepancy of Kennedy & O'Hagan 2001, Bayesian calibration of computer models; Plumlee 2017, Bayesian
calibration of inexact computer models: a random part of the residual, here spanned by the linearised responses of known
laws, each with a normal prior. No law is exact. What a model has is known to a share of what it does; and what the
model has not may be there as a fault of a law of its kind, as large as that share of what the law does: friction that
differs a little by direction looks like a small constant effort, a torque constant that droops like a little voltage
sag.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components

from realitygap.diagnose.candidates.starts import FURTHEST, Start
from realitygap.diagnose.candidates.suspects import neutral
from realitygap.diagnose.data.changes import Suspect
from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.fit.fit import Fit
from realitygap.diagnose.fit.responses import Block, at_one_place
from realitygap.diagnose.likelihood.channel_blocks import ChannelBlocks
from realitygap.diagnose.likelihood.metric import Metric
from realitygap.diagnose.likelihood.whitening import Channel, Whitening
from realitygap.diagnose.search.clocks import of_clocks
from realitygap.robot.drive import Array

SHARE = {"friction": 0.08, "drive": 0.04, "load": 0.04, "contact": 0.12}
"""What ordinary laws are known to, as a share of what they do. Friction differs with direction, angle and temperature
by 5 to 10 % (Armstrong-Hélouvry 1991; Bittencourt & Gunnarsson 2012), a torque constant droops by 2 to 5 % with current
and heat (Hollerbach, Hunter & Ballantyne 1992), masses of a drawing are 2 to 5 % off. Fitted toss by toss, the friction
of a cube on the ground scatters by 12 % (16 recorded tosses)."""
WORST = SHARE["friction"]
"""The same of a named effect that is no fault of these, and of which nothing else is known."""
KNOWN = {"command_delay": 0.04, "command_profile": 0.04, "joint_compliance": 0.2, "backlash": 0.2}
"""Of these more is known. What firmware does to a command is exact, but when it is in force is known to a part of a
sample's period: planted delays came out 0.4 to 4.5 % off beside nearly right laws (root mean square 2.7 %). Gears
stiffen with their load (catalogues of strain wave gears state two or three stiffnesses, the last 1.2 to 1.8 times the
first), and where in them friction sits makes play seem narrower: planted springs came out 25 to 66 % too stiff, play 20
to 26 % too narrow."""
UNSEEN = 1.0
"""What does less than this in a signal of a motion, in standard deviations of all samples together, does not show."""
EVEN = 0.9
"""Cosine of what a joint answers to both sides, below which a straight line does not say what lies between."""
SHORTEST = 0.3
"""Standard deviations of all samples together. A discrepancy that does less could hide nothing."""
OTHER = 0.025
"""What else may be there without being missed, as a delay or an offset, in visible first sizes. With a tenth of these,
67 of 82 machines, planted and recorded, were left with a quarter of that or less once all was found, and 7 with more
than half; and a dead band of half its size passed for it, whose gap went from 6.9 floors to 2.3."""


@dataclass(frozen=True)
class Accepted:
    """A response of an accepted value: its column, what the value is, and what it is in a model without the change."""

    column: int
    suspect: Suspect
    name: str
    value: float
    neutral: float


@dataclass(frozen=True)
class Discrepancy:
    """The law discrepancy that all models of a round are compared with: a linear basis with a normal prior.

    Attributes:
        effective_fraction: how many effective samples a sample of each channel is, where the search stands. Shape
            (channels,).
        responses: what the residual changes by when a law is off by what it is known to, one standard deviation each.
            Shape (m, q).
        laws: the kind of law that each is a fault of: friction, drive, load, clock, or empty for any other.
        accepted: which of them are of values that the search has accepted.
        does: the length of what the largest of each kind of law does at each joint, in the metric.
        most: the largest scale of the discrepancy of each kind of law, in multiples of what is ordinary.
    """

    effective_fraction: Array
    responses: Array
    laws: tuple[str, ...] = ()
    accepted: tuple[Accepted, ...] = ()
    does: Mapping[tuple[str, int], float] = field(default_factory=dict)
    most: Mapping[str, float] = field(default_factory=dict)
    _blocks: dict[str, ChannelBlocks] = field(init=False, repr=False, compare=False, default_factory=dict)

    def thinned(self, whitening: Whitening) -> ChannelBlocks:
        """The responses in the samples that are looked at, which autocorrelation tells: they are the same for every
        model of a round. (k, q).
        """
        if "thin" not in self._blocks:
            self._blocks["thin"] = self._whole(whitening.channels).every(whitening.every.tolist())
        return self._blocks["thin"]

    def of_others(self) -> Discrepancy:
        """Those of what the search has not accepted."""
        own = {a.column for a in self.accepted}
        kept = [k for k in range(len(self.laws)) if k not in own]
        laws = tuple(self.laws[k] for k in kept)
        return replace(self, responses=self.responses[:, kept], laws=laws, accepted=())

    def times(self, amounts: Array, channels: Sequence[Channel]) -> Array:
        """What the residual changes by where each law is off by so many times that. Shape (q,) -> (m,)."""
        return self._whole(channels).times(amounts[:, None])[:, 0]

    def _whole(self, channels: Sequence[Channel]) -> ChannelBlocks:
        if "whole" not in self._blocks:
            self._blocks["whole"] = ChannelBlocks.of(self.responses, [len(c.time) for c in channels])
        return self._blocks["whole"]

    def ordinary(self, joint: int, discrepancy_scale: Mapping[str, float]) -> float:
        """The length of what friction, load or drive may be off by at a joint, whichever is most, where the
        discrepancy of each kind of law has this scale.
        """
        laws = ("friction", "load", "drive")
        return max(discrepancy_scale.get(law, 1.0) * SHARE[law] * self.does.get((law, joint), 0.0) for law in laws)

    def shares(self, fit: Fit) -> Array:
        """How much of each response counts for a fit: of an accepted value as much as the fit has of it. Shape (q,)."""
        out = np.ones(len(self.laws))
        has = {c.suspect: c.parameters for c in fit.changes}
        for a in self.accepted:
            value = abs(has.get(a.suspect, {}).get(a.name, a.neutral))  # inf is of a stop on the other side
            out[a.column] = value / a.value if np.isfinite(value) else 0.0
        return out


@dataclass(frozen=True)
class _Known:
    """The response to one value, and how many times that the model does already.

    Attributes:
        law: of which it is a fault.
        places: the joints where; a link is its joint's.
        response: of the residual. Shape (m,).
        times: what the model has of it, in multiples of the response.
        share: to which it is known.
        block: the number of the block that it is of; -1 for an accepted value.
        uneven: whether a joint answers it unevenly to both sides.
    """

    law: str
    places: tuple[int, ...]
    response: Array
    times: float
    share: float
    block: int = -1
    uneven: bool = False


def law_discrepancy(problem: Problem, at: Fit, blocks: Sequence[Block], metric: Metric) -> Discrepancy:
    """What the residual changes by when each law is off by what it is known to, at a fitted model, and when clocks are.

    Args:
        problem: whose motions were recorded.
        at: the fit, whose changes are part of the model.
        blocks: responses of what could be added: those that respond linearly at single targets count.
        metric: in which effects are compared.
    """
    own = _accepted(problem, at)
    known = [k for k, _ in own] + _of(blocks, metric)
    white = [metric(k.response) for k in known]
    does, scale = _scales(known, white, metric.whitening.parts)
    off = [s * k.response for k, s in zip(known, scale, strict=True)]
    alike: dict[tuple[str, tuple[int, ...]], list[int]] = {}
    for i in range(len(own), len(known)):
        alike.setdefault((known[i].law, known[i].places), []).append(i)
    columns = [(k.law, off[i]) for i, (k, _) in enumerate(own)]
    faults: dict[str, list[Array]] = {}
    for (law, places), at_once in alike.items():
        found = np.column_stack([off[i] for i in at_once])
        seen = np.column_stack([scale[i] * white[i] for i in at_once])
        turn = _once(seen, SHARE[law] * max(does[law, p] for p in places)) if law else np.eye(len(at_once))
        faults.setdefault(law, []).append(found @ turn)
    for law, parts in faults.items():
        columns += [(law, c) for c in _shown(np.hstack(parts), metric).T]
    columns += of_clocks(problem, metric.whitening.channels, at.residual)
    accepted = tuple(a for k, a in own if k.times > 0.0)
    responses = np.column_stack([c for _, c in columns]) if columns else np.zeros((len(at.residual), 0))
    return Discrepancy(metric.whitening.effective_fraction, responses, tuple(law for law, _ in columns), accepted, does)


def nearer(problem: Problem, at: Fit, blocks: Sequence[Block], metric: Metric) -> dict[int, Start]:
    """The starts whose responses count as law discrepancy and were simulated further away than laws may be off, each as
    near as that, by the number of its block. What a law does that is a little off is not what one does that is far off,
    only smaller: of the voltage that sags by 5 % of the supply and of a fifth of that the cosine is 0.9. Where a joint
    has play, 0.2° of tilt decide when it falls to the other side.
    """
    known = [k for k, _ in _accepted(problem, at)] + _of(blocks, metric)
    _, scale = _scales(known, [metric(k.response) for k in known], metric.whitening.parts)
    most: dict[int, float] = {}
    for k, amount in zip(known, scale, strict=True):
        if k.block >= 0 and (k.law or k.uneven) and amount > 0.0:
            most[k.block] = max(most.get(k.block, 0.0), amount)
    return {i: replace(blocks[i].start, share=m) for i, m in most.items() if m < blocks[i].start.share}


def _scales(
    known: Sequence[_Known], white: Sequence[Array], parts: NDArray[np.int64]
) -> tuple[dict[tuple[str, int], float], list[float]]:
    """What the largest of each kind of law does at each place, and how many times its response each value may be off.

    As much in all recordings together as its kind of law, in no signal of a motion where it shows more than that, and
    what the model has not as far as the linearised model holds.

    A law that does much in one motion may be no more wrong in another, and what lasts shows in positions, what is fast
    in velocities: 4 % of what inertia does in a free swing would be an offset of a joint by five degrees elsewhere.

    Args:
        known: the responses.
        white: the same in the metric in which effects are compared. Each (r,), or more than r.
        parts: the number of the signal of a motion that every sample is of. Shape (r,).
    """
    inside = [np.ones(len(parts), dtype=bool), *(parts == part for part in np.unique(parts))]
    sizes = [[float(np.linalg.norm(w[: len(parts)][part])) for part in inside] for w in white]
    does = [_done(known, [size[number] for size in sizes]) for number in range(len(inside))]
    unseen = [0.0, *(UNSEEN for _ in inside[1:])]
    return does[0], [min(map(partial(_scale, k), size, does, unseen)) for k, size in zip(known, sizes, strict=True)]


def _done(known: Sequence[_Known], sizes: Sequence[float]) -> dict[tuple[str, int], float]:
    """The size of what the largest of each kind of law does at each place, where each response has a size."""
    does: dict[tuple[str, int], float] = {}
    for k, size in zip(known, sizes, strict=True):
        for place in k.places:
            does[k.law, place] = max(does.get((k.law, place), 0.0), k.times * size)
    return does


def _once(white: Array, most: float) -> Array:
    """What discrepancies are multiplied by for none of what they do to be larger than all laws of their kind may be off
    by. Shape (n, n).

    Laws of one kind do much the same: Coulomb friction, friction by direction and the Stribeck effect are one fault of
    friction, not three that add up. So the eigenvalues of their common covariance are clipped at `most`².

    Args:
        white: what they do, in the metric. Shape (r, n).
        most: the length in the metric of what the kind of law may be off by.
    """
    length, turn = _directions(white)
    return turn * np.minimum(1.0, most / np.maximum(length, 1e-300))


def _shown(columns: Array, metric: Metric) -> Array:
    """The same discrepancies, all of one kind of law, as few as do the same: their principal components, of which those
    are kept that would show at all if nothing but noise and floors were left. Shape (m, n) -> (m, few).

    What has no sample in common has no component in common either, and stays apart (`ChannelBlocks`).
    """
    bare = replace(metric.whitening, excess=np.zeros(len(metric.whitening.excess)))
    white = bare(columns, metric.weight)[0]
    number, group = connected_components(white.T @ white != 0.0, directed=False)
    few = []
    for k in range(number):
        together = np.flatnonzero(group == k)
        length, turn = _directions(white[:, together])
        few.append(columns[:, together] @ turn[:, length > SHORTEST])
    return np.hstack(few) if few else columns


def _directions(white: Array) -> tuple[Array, Array]:
    """The singular values of whitened responses, (n,), and their right singular vectors, (n, n)."""
    square, turn = np.linalg.eigh(white.T @ white)
    return np.sqrt(np.maximum(square, 0.0)), turn


def _scale(known: _Known, size: float, does: Mapping[tuple[str, int], float], unseen: float) -> float:
    """How many times its response a value may be off, as samples say in which it has a size; `does` is what the largest
    of each kind of law does in them at each place. Of what does no more than `unseen` they say nothing.
    """
    if known.times > 0.0:
        return known.share * known.times
    if not known.law:
        return OTHER
    most = SHARE[known.law] * max(does[known.law, p] for p in known.places)
    return min(max(most, unseen) / size, FURTHEST) if size > 0.0 else FURTHEST


def known_to(suspect: Suspect) -> float:
    """To which share of what it does an effect is known."""
    return KNOWN.get(suspect.effect, SHARE.get(suspect.kind.law, WORST))


def _of(blocks: Sequence[Block], metric: Metric) -> list[_Known]:
    """What could be added at single targets, and responds linearly, or turns with the angle as friction does.

    To both sides where a joint answers them unevenly, as one with play does a pull to one side and to the other.
    """
    chosen: dict[Suspect, dict[tuple[bool, ...], int]] = {}
    for number, block in enumerate(blocks):
        suspect = block.suspect
        if usual(block.start) and at_one_place(suspect):
            chosen.setdefault(suspect, {}).setdefault(_side(block.start), number)
    out = []
    for suspect, sides in chosen.items():
        uneven = _unevenly([blocks[number] for number in sides.values()], metric)
        for number in list(sides.values())[: None if uneven else 1]:
            block, law = blocks[number], suspect.kind.law
            zero = dict(block.start.zero)
            for k, change in enumerate(block.start.tries):
                times = [abs(zero[n] / (change.parameters[n] - zero[n])) for n in block.start.moved(k)] if law else []
                most = max(times, default=0.0)
                response = block.columns[:, k]
                out.append(_Known(law, suspect.joints, response, most, known_to(suspect), number, uneven))
    return out


def usual(start: Start) -> bool:
    """Whether laws are off by what a start tries: by what responds linearly, and friction by the angle."""
    return start.kind == "linear" or (start.kind == "wave" and start.suspect.kind.law == "friction")


def _unevenly(sides: Sequence[Block], metric: Metric) -> bool:
    """Whether what a joint answers to one side is not what it answers to the other, turned round."""
    if len(sides) < 2:
        return False
    up, down = (metric(side.columns[:, 0]) for side in sides[:2])
    return abs(float(up @ down)) < EVEN * float(np.linalg.norm(up) * np.linalg.norm(down))


def _side(start: Start) -> tuple[bool, ...]:
    """Whether each try of a start moves its parameters up."""
    zero = dict(start.zero)
    return tuple(c.parameters[n] > zero[n] for k, c in enumerate(start.tries) for n in start.moved(k))


def _accepted(problem: Problem, at: Fit) -> list[tuple[_Known, Accepted]]:
    """What the model has by its changes, in the order of the fit's values; shapes have no law of their own."""
    out = list[tuple[_Known, Accepted]]()
    for k, ((i, name), value) in enumerate(zip(at.names, at.value, strict=True)):
        suspect = at.changes[i].suspect
        if not suspect.kind.parameter(name).shape:
            times = abs(value) / at.size[k]
            known = _Known(suspect.kind.law, suspect.joints, at.slope[:, k], times, known_to(suspect))
            absent = neutral(problem.plant, suspect)[name]
            absent = absent if np.isfinite(absent) else 0.0
            out.append((known, Accepted(len(out), suspect, name, abs(float(value)), absent)))
    return out
