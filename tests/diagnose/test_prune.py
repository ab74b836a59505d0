"""What a finding's own interval says of it, on the bundled demo (synthetic)."""

from dataclasses import replace

import numpy as np
from demo_problem import suspect_of
from realitygap.diagnose.candidates.starts import guess
from realitygap.diagnose.candidates.suspects import neutral
from realitygap.diagnose.data.changes import Change
from realitygap.diagnose.data.problem import Problem
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.search.criterion import Criterion
from realitygap.diagnose.search.evidence import Scored
from realitygap.diagnose.search.prune import superfluous, untold, wald_losses


def beside_friction(simulations: Simulations, other: Change) -> tuple[Criterion, Scored]:
    """The elbow's friction and something else, fitted together."""
    problem, criterion = simulations.problem, Criterion(simulations, [])
    fitted = criterion.fit([guess(problem, suspect_of(problem, "coulomb_friction", "elbow")), other])
    assert fitted is not None
    return criterion, fitted


def test_an_interval_tells_what_was_planted_and_not_what_is_as_the_model_has_it(
    problem: Problem, simulations: Simulations
) -> None:
    constant = suspect_of(problem, "constant_effort", "elbow")
    criterion, fitted = beside_friction(simulations, guess(problem, constant))
    friction = fitted.fit.changes[0].suspect
    losses = wald_losses(problem, fitted)
    limit = 5.0
    assert superfluous(problem, fitted, [], limit) == [constant]
    assert superfluous(problem, fitted, [constant], limit) == []
    assert superfluous(problem, fitted, [], 2.0 * losses[friction]) == [constant, friction]
    assert untold(problem, criterion.as_told(fitted.fit)) == {constant}
    assert losses[friction] > losses[constant]


def test_what_is_sure_by_its_evidence_may_lie_nearer_to_what_the_model_has(
    problem: Problem, simulations: Simulations
) -> None:
    _, fitted = beside_friction(simulations, guess(problem, suspect_of(problem, "constant_effort", "elbow")))
    friction = fitted.fit.changes[0].suspect
    missing = (fitted.fit.value[0] - neutral(problem.plant, friction)["torque"]) / fitted.fit.size[0]
    for errors, told in ((1.6, True), (1.2, False)):
        away = np.zeros(len(fitted.fit.value))
        away[0] = missing / errors
        wide = replace(fitted, away=away)
        assert friction in untold(problem, wide)
        assert (friction not in untold(problem, wide, {friction})) == told


def test_a_limit_that_may_as_well_be_endless_is_not_told(problem: Problem, simulations: Simulations) -> None:
    profile = guess(problem, suspect_of(problem, "command_profile", "elbow"))
    profile = replace(profile.at({"acceleration": 3e3, "speed": np.inf}), free=("acceleration",))
    criterion, fitted = beside_friction(simulations, profile)
    assert untold(problem, criterion.as_told(fitted.fit)) == {profile.suspect}
