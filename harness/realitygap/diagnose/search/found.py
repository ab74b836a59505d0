"""What a search found, which is judged."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field

from realitygap.diagnose.data.changes import Suspect
from realitygap.diagnose.fit.responses import Block
from realitygap.diagnose.likelihood.floors import Floors
from realitygap.diagnose.search.criterion import Criterion
from realitygap.diagnose.search.evidence import Scored
from realitygap.diagnose.search.linear import LinearGain
from realitygap.diagnose.search.rivals import Rival

Said = tuple[Suspect, frozenset[Suspect]]
"""A finding, or a law of which it is a special case, and the two findings that it might say together."""


@dataclass(frozen=True)
class Apart:
    """What was seen to be far from saying two findings together, beside some findings and so beside more than these."""

    said: frozenset[Said] = frozenset()
    beside: frozenset[Suspect] = frozenset()

    def among(self, there: Collection[Suspect]) -> frozenset[Said]:
        """The same of a model with these findings: nothing, where one has gone that they were seen beside."""
        return self.said if self.beside.issubset(there) else frozenset()


@dataclass
class Found:
    """What a search found.

    Attributes:
        base: the scenario's own model, by the criterion of the last round.
        best: the model with the best evidence.
        cautious: the same, for intervals.
        limit: what a finding has to gain.
        least: the same for each, or what laws of its kind leave of what the best model explains, where that is more.
        floors: of the best model.
        criterion: by which models were compared in the last round.
        gains: evidence that is lost without each finding, by suspect.
        without: the model without each finding, its other values fitted anew.
        rivals: what could stand in the place of each finding, the closest first.
        candidates: what was closest and not taken, best first.
        short: what it gains where it was fitted, and what it would have to gain.
        beaten: findings in whose place an unnamed effort gains what a name has to, though it is none itself.
        cut: whether the search was ended while it may have found more.
        blocks: the responses of what could still be added, in the last round.
        fuller: the model from which findings were left out in the end, as they gain too little; None where none was.
        adjusted: what of the best model is no finding, but what its laws are off by (`judge.adjust`).
        apart: what was seen to be far from saying two of the findings together, which is not asked again.
    """

    base: Scored
    best: Scored
    cautious: Scored
    limit: float
    least: Mapping[Suspect, float]
    floors: Floors
    criterion: Criterion
    gains: dict[Suspect, float] = field(default_factory=dict)
    without: dict[Suspect, Scored] = field(default_factory=dict)
    rivals: dict[Suspect, list[Rival]] = field(default_factory=dict)
    candidates: list[LinearGain] = field(default_factory=list)
    short: Mapping[Suspect, tuple[float, float]] = field(default_factory=dict)
    beaten: Collection[Suspect] = ()
    cut: bool = False
    blocks: Sequence[Block] = ()
    fuller: Scored | None = None
    adjusted: tuple[Suspect, ...] = ()
    apart: Apart = Apart()
