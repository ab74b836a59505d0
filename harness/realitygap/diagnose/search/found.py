"""What a search has found so far."""

from __future__ import annotations

from dataclasses import dataclass, field

from realitygap.diagnose.data.decoys import DECOYS
from realitygap.diagnose.data.problem import Change, Suspect
from realitygap.diagnose.fit.fit import Fit
from realitygap.diagnose.search.screen import Screened


@dataclass
class Step:
    """One accepted finding, what the held-out motions cost before and after, all suspects as screened then, and the
    fits with those that were tried.
    """

    suspect: Suspect
    before: float
    after: float
    ranked: list[Screened] = field(default_factory=list)
    tried: list[Fit] = field(default_factory=list)


@dataclass
class Found:
    """What a search found.

    Attributes:
        base: the cost of the scenario's own model.
        fit: the accepted changes, jointly fitted.
        steps: in the order of acceptance.
        told: by the recordings themselves, which show it and its size.
        refused: sentences on suspects that were close and why they were not named.
        let_go: what was found and not named after all, because it is not the cause of the gap.
        fits: those that were made under the present floors, by their first guesses.
    """

    base: Fit
    fit: Fit
    steps: list[Step] = field(default_factory=list)
    told: list[Suspect] = field(default_factory=list)
    refused: list[str] = field(default_factory=list)
    let_go: list[Change] = field(default_factory=list)
    fits: dict[tuple[Change, ...], Fit] = field(default_factory=dict)

    def forget(self, suspect: Suspect) -> None:
        """Take out the step of a finding that does not stay."""
        self.steps = [s for s in self.steps if s.suspect != suspect]


def name(suspect: Suspect) -> str:
    """An effect and its target, for people."""
    return f"{suspect.effect} at {suspect.where}{' (outside the list)' * (suspect.effect in DECOYS)}"
