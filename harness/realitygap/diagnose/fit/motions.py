"""The motions by which models are compared: their residual, faithful or as coarse as is enough."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from realitygap.diagnose.data.changes import Change
from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.likelihood.whitening import stacked
from realitygap.robot.drive import Array


@dataclass(frozen=True)
class Motions:
    """Motions that are simulated together, model by model.

    Attributes:
        simulations: of the problem.
        cases: their numbers.
        coarse: where only the change of the traces counts, the share of the step rate that is enough, by case of the
            problem (`Floors.coarse`).
    """

    simulations: Simulations
    cases: Sequence[int]
    coarse: Sequence[float]

    @property
    def problem(self) -> Problem:
        """Whose motions they are."""
        return self.simulations.problem

    def residual(self, changes: Sequence[Change]) -> Array | None:
        """The stacked residual with changes, (m,); None where a motion cannot be simulated."""
        return residual(self.simulations, changes, self.cases)

    def residuals(self, models: Sequence[Sequence[Change]]) -> list[Array | None]:
        """The same of many models, as coarsely as is faithful, simulated side by side."""
        asked = [self.simulations.query(changes, c, coarse=self.coarse) for changes in models for c in self.cases]
        answers, size = self.simulations.ask(asked), len(self.cases)
        out: list[Array | None] = []
        for k in range(len(models)):
            signals = [a for a in answers[k * size : (k + 1) * size] if a is not None]
            out.append(stacked(self.problem, self.cases, signals) if len(signals) == size else None)
        return out


def residual(
    simulations: Simulations, changes: Sequence[Change], cases: Sequence[int], coarse: Sequence[float] | None = None
) -> Array | None:
    """The stacked residual of some cases with changes, (m,); None where one cannot be simulated."""
    answers = simulations.of(changes, cases, coarse=coarse)
    signals = [a for a in answers if a is not None]
    return stacked(simulations.problem, cases, signals) if len(signals) == len(cases) else None
