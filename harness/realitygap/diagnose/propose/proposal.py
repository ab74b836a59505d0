"""A proposal: motions, what each will settle, and what none can."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from realitygap.diagnose.data.changes import Suspect
from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.propose.design import Answer, shares, told
from realitygap.diagnose.propose.excitation import Excitation
from realitygap.diagnose.propose.explanations import Open, Question
from realitygap.diagnose.propose.limits import Limits
from realitygap.diagnose.propose.predict import Predictions
from realitygap.diagnose.rehearse.rehearse import Rehearsal
from realitygap.files.interrupted import Interrupted
from realitygap.robot.drive import Array


@dataclass(frozen=True)
class Weak:
    """A fitted value of the named model, and how much better a motion tells it.

    Attributes:
        suspect, parameter: what it is.
        unit: of the value.
        value: fitted to the recordings.
        now: half of its 95 % interval.
        then: the same with the motion.
        half: how long one has to record the motion until the interval is half as wide [s]; infinite where it never is.
    """

    suspect: Suspect
    parameter: str
    unit: str
    value: float
    now: float
    then: float
    half: float


@dataclass(frozen=True)
class Proposed:
    """One motion, and what it will settle.

    Attributes:
        motion: what is recorded.
        case: its number in the proposal's problem; -1 where the motion as a whole was not predicted.
        answers: to every question.
        engines: in which it was seen to stay within the limits.
        weak: how much better the values of the named model are told.
    """

    motion: Excitation
    case: int
    answers: tuple[Answer, ...]
    engines: tuple[str, ...]
    weak: tuple[Weak, ...] = ()


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
        shown: what the motions would show of each effect, where nothing is recorded yet.
        ended: the signal that ended the work, where the best so far is all there is.
    """

    problem: Problem
    open: Open
    limits: Limits
    home: Array
    proposed: list[Proposed] = field(default_factory=list)
    predictions: Predictions | None = None
    hopeless: tuple[Question, ...] = ()
    notes: list[str] = field(default_factory=list)
    ended: Interrupted | None = None
    shown: Rehearsal | None = None

    def reached(self, proposed: Proposed) -> list[tuple[Question, Answer]]:
        """The questions that a motion within the limits can move, with what this one does to them."""
        both = zip(self.open.questions, proposed.answers, strict=True)
        return [(q, a) for q, a in both if q not in self.hopeless]

    def least(self, proposed: Proposed) -> float:
        """The expected logarithm of the odds of the question that a motion settles least."""
        return min((a.least for _, a in self.reached(proposed)), default=0.0)

    def ranked(self) -> list[Proposed]:
        """The motions, first the one that has most of what the best of them do to each question that any can move."""
        asked = [k for k, q in enumerate(self.open.questions) if q not in self.hopeless]
        if not asked:
            return list(self.proposed)
        still = told(-np.abs([self.open.questions[k].now for k in asked]))
        each = told(np.array([[p.answers[k].least for k in asked] for p in self.proposed]))
        rank = shares(each, still, each.max(axis=0))
        return [self.proposed[k] for k in np.argsort(-rank, kind="stable")]
