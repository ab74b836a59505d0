"""The criterion: the evidence of models under one likelihood, with a fit of each under it.

One round compares all its models by it: the same channels, floors and law discrepancy, so that a difference in evidence
is a log Bayes factor.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from realitygap.diagnose.candidates.starts import Start, softer, starts, swings
from realitygap.diagnose.data.case import JOINT_SIGNALS
from realitygap.diagnose.data.changes import Change, Suspect, as_read, changed, stands_beside
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.fit.fit import Care, Fit, as_seen, fit, residual_near
from realitygap.diagnose.fit.motions import Motions
from realitygap.diagnose.fit.responses import Block, respond, single
from realitygap.diagnose.likelihood.floors import Floors, measure
from realitygap.diagnose.likelihood.metric import Metric
from realitygap.diagnose.likelihood.whitening import channels, effective_fraction, spans
from realitygap.diagnose.search.discrepancy import SHARE, Discrepancy, law_discrepancy, nearer
from realitygap.diagnose.search.evidence import TYPICAL, Scored, cautious, ordinary, score, scored_and_sharp, sharp
from realitygap.diagnose.search.linear import linear_at
from realitygap.diagnose.search.reweighted import SETTLE, SETTLED, reweighted
from realitygap.robot.drive import EFFORT, Array

PROMISING = 3.0
"""What the softest spring of a joint promises in evidence, at least, for softer ones to be tried: odds of 20 : 1."""
ELSEWHERE = (0.8, 1.25)
"""The fit of a body without joints is tried again from these multiples of its values: contacts, of which all is made
that it does, make it rough."""
AS_LARGE = 0.75
"""What a finding does, in multiples of what laws of its kind are off by, to be named. Beside nearly right laws, planted
at five seeds, 50 true findings did 0.98 times that or more, but for a limit and a ripple; three false ones did 0.23 to
0.55, and three at seeds before 0.4 to 0.7. Of an arm of six joints that lacks twenty effects, two true gains did 0.56
and 0.82."""


class Criterion:
    """By which all models of one round are compared: floors, training motions, and the discrepancy of every law.

    Attributes:
        simulations: of the problem.
        floors: of the model that the round started from; measured where they are not known.
        train: the cases that are fitted.
        motions: they, as they are simulated.
        channels: of their stacked residual.
        discrepancy: what laws may be off by.
    """

    def __init__(self, simulations: Simulations, changes: Sequence[Change], floors: Floors | None = None) -> None:
        self.simulations, self.problem = simulations, simulations.problem
        self.train = self.problem.of("train")
        self.floors: Floors = measure(simulations, changes, self.train) if floors is None else floors
        self.motions = Motions(simulations, self.train, self.floors.coarse)
        self.channels = channels(self.problem, self.floors, self.train)
        none = np.zeros((sum(len(c.time) for c in self.channels), 0))
        self.discrepancy = Discrepancy(np.ones(len(self.channels)), none)
        self._discrepancy_metric: Metric | None = None

    def responses(self, at: Fit, everyone: Sequence[Suspect]) -> list[Block]:
        """The responses of every suspect that can stand beside the changes of a fit."""
        accepted = [c.suspect for c in at.changes]
        beside = [s for s in self.possible(at, everyone) if stands_beside(s, accepted)]
        found = self.simulations.side_by_side(lambda s: starts(self.problem, s, self._of_joint(at, s)), beside)
        tried = [start for of in found for start in of]
        return self._softer(at, self._respond(at, tried))

    def _respond(self, at: Fit, tried: Sequence[Start]) -> list[Block]:
        return respond(self.motions, at.changes, tried, self.channels)

    def _softer(self, at: Fit, blocks: list[Block]) -> list[Block]:
        """Responses with those of softer springs of a joint, as long as its softest promises most of them.

        What a motor is rated for says little of how stiff its joint is: of a light head, tilted by one of 20 N·m, the
        softest spring that was tried swung at 21 Hz, and the one that was there at 12.
        """
        out, springs = blocks, [b for b in blocks if b.start.kind == "inverse" and swings(b.suspect)]
        while springs:
            lines, tried = linear_at(self.plain(at), springs), list[Start]()
            for suspect in dict.fromkeys(b.suspect for b in springs):
                gains = {b.start: lines.gain([i]) for i, b in enumerate(springs) if b.suspect == suspect}
                softest = min(gains, key=lambda start: start.stiffness)
                if max(gains, key=lambda start: gains[start]) is softest and gains[softest] > PROMISING:
                    tried += softer(softest)
            asked = self._respond(at, tried) if tried else []
            out = [*out, *asked]
            springs = [b for b in springs if b.suspect in {a.suspect for a in asked}] + asked
        return out

    def possible(self, at: Fit, everyone: Sequence[Suspect]) -> list[Suspect]:
        """The suspects that could act in the model of a fit."""
        plant = changed(self.problem.plant, at.changes, self.problem.plant)
        return [s for s in everyone if s.possible(plant)]

    def set_discrepancy(self, at: Fit, blocks: Sequence[Block]) -> None:
        """Let laws be as far off as they may be at a fit, which responses tell (`discrepancy`), and count
        effective samples as what that leaves lasts.

        None of the models that are compared with the fit has laws that are further off than it says, or than is
        ordinary: noise is told by the larger of nested models (Mallows 1973). What is missing makes laws look poor,
        which would pass for what is missing. Of an axis with 2.5 times the dry friction of its model, the one with more
        viscous friction and friction that is off by 16 % was likelier by 106 than the true one, whose laws are off by
        4 %; with ordinary laws it is 190 behind.
        """
        self.set_effective_fraction(at.residual)
        self._discrepancy_metric = metric = self.plain(at).metric
        near = nearer(self.problem, at, blocks, metric)
        answers = self._respond(at, list(near.values()))
        of = {start: number for number, start in near.items()}
        again = {of[b.start]: b for b in answers}
        self.discrepancy = law_discrepancy(self.problem, at, [again.get(i, b) for i, b in enumerate(blocks)], metric)
        there = self.score(at)
        self.set_effective_fraction(there.left)
        self.discrepancy = replace(
            self.discrepancy, most={law: max(scale, 1.0) for law, scale in there.discrepancy_scale.items()}
        )

    def set_effective_fraction(self, left: Array) -> None:
        """Count effective samples by how long what is left of a residual lasts (its autocorrelation). Shape (m,)."""
        self.discrepancy = replace(self.discrepancy, effective_fraction=effective_fraction(self.channels, left))

    def score(self, found: Fit) -> Scored:
        """The evidence of a fit: its log marginal likelihood, with the scales of the discrepancy at their best."""
        return score(self.channels, found, self.discrepancy)

    def ordinary(self, found: Scored, joint: int, other: Fit) -> bool:
        """Whether what parts another fit from a model is no more than what laws may be off by at a joint."""
        change = float(np.linalg.norm(found.metric(other.residual - found.fit.residual)))
        return change <= self.discrepancy.ordinary(joint, found.discrepancy_scale)

    def typical(self, suspect: Suspect) -> float:
        """The length of what laws of a suspect's kind are off by where it sits, in a typical machine; an effort without
        a law may stand for any of them.
        """
        kinds = SHARE if suspect.table is not None else {suspect.kind.law}.intersection(SHARE)
        lengths = {k: np.linalg.norm([self.discrepancy.does.get((k, j), 0.0) for j in suspect.joints]) for k in kinds}
        return max((TYPICAL * SHARE[k] * float(length) for k, length in lengths.items()), default=0.0)

    def alike(self, fit: Fit, other: Fit, suspect: Suspect) -> bool:
        """Whether two fits differ by no more than ordinary laws of a suspect's kind are off by.

        Not only a typical machine's: of a plant that nobody had seen, dry friction that was 2 to 4 % more to one side,
        and 5 to 8 % uneven over the angle, was told by side at three joints, as 5 % more. Of four servos and axes whose
        friction needs telling so, planted or recorded, it was 14 to 50 % more.
        """
        return self.apart(fit, other) <= self.typical(suspect) / TYPICAL

    def apart(self, fit: Fit, other: Fit) -> float:
        """The length of what parts two fits, in the metric in which what laws do was told."""
        return float(np.linalg.norm(self.discrepancy_metric(np.nan_to_num(other.residual - fit.residual))))

    def sharp(self, found: Fit) -> Scored:
        """The evidence, and the metric in which moves from a fit are looked for."""
        return sharp(self.channels, found, self.discrepancy)

    def as_told(self, found: Fit) -> Scored:
        """The same where laws are ordinary at best, for intervals."""
        return cautious(self.channels, found, self.discrepancy)

    def cautious(self, found: Fit) -> Scored:
        """The same with how far the likeliest values are in simulation, since a limit does not respond linearly."""
        at = self.as_told(found)
        likeliest = fit(self.motions, found.changes, at.metric, found, "compared")
        return at if likeliest is None else replace(at, away=(likeliest.value - found.value) / found.size)

    @property
    def discrepancy_metric(self) -> Metric:
        """The metric in which what laws do was told (`Discrepancy.does`)."""
        if self._discrepancy_metric is None:
            raise RuntimeError("nobody has said what laws do")
        return self._discrepancy_metric

    def tolerant(self, found: Fit) -> Scored:
        """The evidence where the laws of what a fit has not are as far off as a typical machine's."""
        return ordinary(self.channels, found, self.discrepancy.of_others())

    def plain(self, found: Fit) -> Scored:
        """The same as if laws were exact: quick, and enough to tell what is worth more."""
        return sharp(
            self.channels, found, Discrepancy(self.discrepancy.effective_fraction, self.discrepancy.responses[:, :0])
        )

    def fit(self, changes: Sequence[Change], known: Fit | None = None, care: Care = "whole") -> Scored | None:
        """Changes fitted, with their evidence; None where they cannot be simulated, or where the values that fit are
        not these effects, which a quick fit leaves open.

        Values are fitted as if laws were exact, which tells them best: what laws may be wrong by could do much the same
        as they. Models that are only compared are moved on from there to where their evidence is best (`settled`).

        Args:
            changes: with first guesses; what stands in the known fit too may turn with a joint's zero (`as_read`).
            known: a fit near by, whose derivatives may be taken at first.
            care: how carefully.
        """
        if known is not None:
            changes = as_read(changes, known.changes, self.problem.plant)
        if known is None or care == "whole":
            first = self.motions.residual(changes)
        else:
            first = residual_near(self.motions, known, changes)
        if first is None:
            return None
        start = self.plain(Fit(tuple(changes), first))
        best = reweighted(self.motions, self.plain, start, known, "quick" if care == "quick" else "compared")
        if best is None or (care != "quick" and self.absurd(best)):
            return None
        if care != "whole":
            there = self.settled(best.fit, care)
            return None if care != "quick" and self.absurd(there) else there
        found = fit(self.motions, best.fit.changes, best.metric, best.fit)
        return None if found is None else self.score(found)

    def seen(self, found: Scored) -> Scored:
        """A fitted model of which values that show nowhere are the scenario's own (`fit.as_seen`)."""
        seen = as_seen(self.motions, found.fit, found.metric)
        return replace(found, fit=seen)

    def refined(self, quick: Scored) -> Scored | None:
        """A quick fit, fitted to be compared; as it is where it has more evidence, since it may be near another best
        place where law discrepancy counts.
        """
        full = self.fit(quick.fit.changes, quick.fit, "compared")
        better = full is not None and full.evidence < quick.evidence and not self.absurd(quick)
        return quick if better else full

    def settled(self, at: Fit, care: Care = "compared") -> Scored:
        """A fit, moved on in the metric of moves to where its evidence is best, for models to be compared as they are.

        What laws are off by draws values away where it counts as noise, and another effect may mend that: a ripple of
        0.235 N·m was fitted as 0.213 beside friction that is uneven by some per cent, and an offset that the joint has
        not gained 80 in evidence; it gains 14 where both models are at their best.
        """
        best, moves = scored_and_sharp(self.channels, at, self.discrepancy)
        last = 1 if care == "quick" else SETTLE
        for number in range(last if self.discrepancy.laws and at.names else 0):
            done = fit(self.motions, best.fit.changes, moves.metric, best.fit, care)
            if done is None:
                break
            if number + 1 < last:
                there, moves = scored_and_sharp(self.channels, done, self.discrepancy)
            else:
                there = self.score(done)
            gain = there.evidence - best.evidence
            best = there if gain > 0.0 else best
            if gain < SETTLED:
                break
        return best

    def elsewhere(self, found: Scored) -> Scored:
        """The best of a model and of its fits from other values, where contacts make fits rough: without joints."""
        best = found
        for factor in ELSEWHERE if not self.problem.plant.model.joints else ():
            moved = [c.at({n: factor * c.parameters[n] for n in c.free}) for c in found.fit.changes]
            again = self.fit(moved)
            best = best if again is None else max(best, again, key=lambda s: s.evidence)
        return best

    def absurd(self, found: Scored) -> bool:
        """Whether some values of a model are not the effect that they are of, as a Stribeck friction that rises with
        speed.
        """
        return any(change.absurd(self.problem.plant) for change in found.fit.changes)

    def _of_joint(self, at: Fit, suspect: Suspect) -> list[Array]:
        """The residual of a suspect's joint in floors, by training motion, for what shows in a spectrum: (t, signals).

        Where efforts are told nothing leads a joint back, and what an effort does adds up twice: it shows in the
        acceleration, of which the slow rest of the motion has little.
        """
        if not single(suspect):
            return []
        joint = suspect.indices[0]
        column, driven = int(np.sum(self.problem.judged[:joint])), self.problem.plant.drive["meaning"][joint] != EFFORT
        out: dict[int, dict[str, Array]] = {}
        stamps: dict[int, Array] = {}
        for channel, span in spans(self.channels):
            if channel.signal in JOINT_SIGNALS and channel.column == column:
                floor = max(float(np.hypot(channel.noise, np.median(channel.slow))), 1e-12)
                out.setdefault(channel.case, {})[channel.signal] = at.residual[span] / floor
                stamps[channel.case] = channel.time
        seen = [out[c] if driven else _accelerations(stamps[c], out[c]) for c in self.train if c in out]
        return [np.column_stack(list(of.values())) for of in seen]


def _accelerations(time: Array, of: Mapping[str, Array]) -> dict[str, Array]:
    """Residuals of a joint's signals (t,), with that of its motion as acceleration."""
    effort = {"effort": of["effort"]} if "effort" in of else {}
    if "velocity" in of:
        return {"acceleration": np.gradient(of["velocity"], time), **effort}
    if "position" in of:
        return {"acceleration": np.gradient(np.gradient(of["position"], time), time), **effort}
    return effort
