"""What a finding's own interval says of it, on the bundled demo (synthetic)."""

from dataclasses import replace

import numpy as np
from demo_problem import demo_problem, suspect_of
from realitygap.diagnose.candidates.starts import guess
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.search.prune import straight_losses, superfluous, untold
from realitygap.diagnose.search.yardstick import Yardstick


def test_an_interval_tells_what_was_planted_and_not_what_is_as_the_model_has_it() -> None:
    problem = demo_problem()
    friction = suspect_of(problem, "coulomb_friction", "elbow")
    constant = suspect_of(problem, "constant_effort", "elbow")
    with Simulations(problem, 1) as simulations:
        yardstick = Yardstick(simulations, [])
        fitted = yardstick.fit([guess(problem, friction), guess(problem, constant)])
        assert fitted is not None
        losses = straight_losses(problem, fitted)
        limit = 5.0
        assert superfluous(problem, fitted, [], limit) == [constant]
        assert superfluous(problem, fitted, [constant], limit) == []
        assert superfluous(problem, fitted, [], 2.0 * losses[friction]) == [constant, friction]
        assert untold(problem, yardstick.as_told(fitted.fit)) == {constant}
    assert losses[friction] > losses[constant]


def test_a_limit_that_may_as_well_be_endless_is_not_told() -> None:
    problem = demo_problem()
    friction = suspect_of(problem, "coulomb_friction", "elbow")
    profile = suspect_of(problem, "command_profile", "elbow")
    with Simulations(problem, 1) as simulations:
        yardstick = Yardstick(simulations, [])
        beside = guess(problem, profile)
        beside = replace(beside.at({"acceleration": 3e3, "speed": np.inf}), free=("acceleration",))
        fitted = yardstick.fit([guess(problem, friction), beside])
        assert fitted is not None
        assert untold(problem, yardstick.as_told(fitted.fit)) == {profile}
