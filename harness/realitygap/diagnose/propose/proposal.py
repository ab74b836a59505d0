"""A proposal: motions, what each will settle, and what none can."""

from __future__ import annotations

from dataclasses import dataclass, field

from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.propose.design import Answer
from realitygap.diagnose.propose.explanations import Open, Question
from realitygap.diagnose.propose.limits import Limits
from realitygap.diagnose.propose.motion import Motion
from realitygap.diagnose.propose.predict import Predictions
from realitygap.robot.drive import Array


@dataclass(frozen=True)
class Proposed:
    """One motion, and what it will settle.

    Attributes:
        motion: what is recorded.
        case: its number in the proposal's problem.
        answers: to every question.
        engines: in which it was seen to stay within the limits.
    """

    motion: Motion
    case: int
    answers: tuple[Answer, ...]
    engines: tuple[str, ...]


@dataclass
class Proposal:
    """Motions that tell apart what the recordings leave open.

    Attributes:
        problem: the recordings, and behind them the motions.
        open: what is left open.
        limits: what no motion leaves.
        home: the pose in which all start and end. Shape (n,).
        proposed: the motions, the best first.
        predictions: of these motions; None where there are none.
        hopeless: questions that no motion within the limits moves.
        notes: sentences on how it was done.
    """

    problem: Problem
    open: Open
    limits: Limits
    home: Array
    proposed: list[Proposed] = field(default_factory=list)
    predictions: Predictions | None = None
    hopeless: tuple[Question, ...] = ()
    notes: list[str] = field(default_factory=list)

    def reached(self, proposed: Proposed) -> list[tuple[Question, Answer]]:
        """The questions that a motion within the limits can move, with what this one does to them."""
        both = zip(self.open.questions, proposed.answers, strict=True)
        return [(q, a) for q, a in both if q not in self.hopeless]

    def least(self, proposed: Proposed) -> float:
        """The expected logarithm of the odds of the question that a motion settles least."""
        return min((a.least for _, a in self.reached(proposed)), default=0.0)
