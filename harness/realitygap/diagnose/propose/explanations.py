"""Explanations that the recordings leave open, and the questions between them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

from realitygap.diagnose.data.changes import Suspect
from realitygap.diagnose.result.story_text import rival_label, suspect_label
from realitygap.diagnose.search.evidence import Scored
from realitygap.diagnose.search.rivals import Rival

MOST = 3
"""Rivals of a finding that are told apart."""
ELSE = "something else"
"""What stands for a model that leaves to no name what a finding explains."""


@dataclass(frozen=True)
class Question:
    """Two explanations that the recordings leave open.

    Attributes:
        one, other: their numbers among all explanations.
        names: what each says, in words.
        targets: where what they say sits.
        now: the logarithm of the odds for the first one, on the present recordings.
    """

    one: int
    other: int
    names: tuple[str, str]
    targets: tuple[Suspect, ...]
    now: float

    def __str__(self) -> str:
        return f"{self.names[0]} against {self.names[1]}"


@dataclass(frozen=True)
class Open:
    """Explanations, each a model fitted to the recordings, the named one first; and the questions between them."""

    explanations: tuple[Scored, ...]
    questions: tuple[Question, ...]

    def within(self, odds: float) -> Open:
        """The same without the questions that the recordings settle, whose odds have a larger logarithm, and without
        rivals that none of the others is about.
        """
        asked = [q for q in self.questions if abs(q.now) < odds]
        left = sorted({0, *(number for q in asked for number in (q.one, q.other))})
        questions = tuple(replace(q, one=left.index(q.one), other=left.index(q.other)) for q in asked)
        return Open(tuple(self.explanations[number] for number in left), questions)


def shown(open_: Open, limit: float) -> list[str]:
    """What the recordings show already, though no diagnosis has named it: it gains more than a name needs."""
    return [q.names[0] for q in open_.questions if q.names[1] == ELSE and q.now > limit]


def left_open(best: Scored, rivals: Mapping[Suspect, Sequence[Rival]], unnamed: Mapping[Suspect, Scored]) -> Open:
    """The named model and what the recordings cannot tell from it, in pairs.

    Args:
        best: the named model.
        rivals: of each finding, the closest first.
        unnamed: models with one more effect than the named one, which the recordings neither show nor exclude.
    """
    explanations, questions = [best], list[Question]()
    for suspect, listed in rivals.items():
        near = [r for r in listed if r.open][:MOST]
        sides = [_Side(0, suspect_label(suspect), (suspect,), 0.0)]
        sides += [_Side(len(explanations) + k, rival_label(r), r.suspects, -r.behind) for k, r in enumerate(near)]
        explanations += [r.scored for r in near]
        questions += _pairs(sides)
    sides = [
        _Side(len(explanations) + k, suspect_label(s), (s,), m.evidence - best.evidence)
        for k, (s, m) in enumerate(unnamed.items())
    ]
    explanations += unnamed.values()
    questions += _pairs([*sides, _Side(0, ELSE, (), 0.0)])
    return Open(tuple(explanations), tuple(questions))


@dataclass(frozen=True)
class _Side:
    """One side of a question; `evidence` is beside that of the named model."""

    number: int
    name: str
    targets: tuple[Suspect, ...]
    evidence: float


def _pairs(sides: Sequence[_Side]) -> list[Question]:
    return [
        Question(a.number, b.number, (a.name, b.name), (*a.targets, *b.targets), a.evidence - b.evidence)
        for a, b in combinations(sides, 2)
    ]
