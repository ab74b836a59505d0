"""A round of a search that has found something, right or wrong, on recordings of the demo (synthetic)."""

from collections.abc import Sequence
from dataclasses import dataclass

from demo_problem import demo_problem, suspect_of
from realitygap.diagnose.candidates.starts import guess
from realitygap.diagnose.data.changes import Change, ModelKey, model_key
from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.fit.fit import Fit
from realitygap.diagnose.fit.motions import residual
from realitygap.diagnose.likelihood.floors import measure
from realitygap.diagnose.rehearse.planting import plant_recordings
from realitygap.diagnose.search.round import Round
from realitygap.diagnose.search.search import needed

Effects = dict[tuple[str, str], dict[str, float]]
"""Values of effects, by effect and target."""


@dataclass(frozen=True)
class Stood:
    """A round, and what is right where it stands."""

    simulations: Simulations
    round_: Round
    right: ModelKey


def stood(
    missing: Effects, wrong: Effects | Sequence[Change], others: Sequence[tuple[str, str]], bare: Problem | None = None
) -> Stood:
    """A round of a search that found something wrong, of recordings (the demo's) where something is missing."""
    bare = demo_problem() if bare is None else bare

    def of(effects: Effects | Sequence[Change]) -> list[Change]:
        if not isinstance(effects, dict):
            return list(effects)
        return [guess(bare, suspect_of(bare, name, at)).at(values) for (name, at), values in effects.items()]

    with Simulations(bare, 2) as simulations:
        floors = measure(simulations, [])
    problem = plant_recordings(bare, floors, of(missing), "mujoco")
    simulations = Simulations(problem, 2)
    left = residual(simulations, [], problem.of("train"))
    assert left is not None
    everyone = [c.suspect for c in (*of(wrong), *of(missing))] + [suspect_of(problem, *o) for o in others]
    at = Fit(tuple(of(wrong)), left)
    round_ = Round(simulations, at, everyone, needed(len(everyone)), Fit((), left), print)
    assert model_key(round_.now.fit.changes) == model_key(of(wrong))
    return Stood(simulations, round_, model_key(of(missing)))
