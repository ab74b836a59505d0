"""What stands in the place of a finding, on recordings of the bundled demo (synthetic) with planted effects."""

from demo_problem import FRICTION, demo_problem, suspect_of
from realitygap.diagnose.candidates.starts import guess
from realitygap.diagnose.data.changes import standing
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.fit.fit import Fit
from realitygap.diagnose.fit.responses import residual
from realitygap.diagnose.likelihood.floors import measure
from realitygap.diagnose.rehearse.planting import plant_recordings
from realitygap.diagnose.search.exchange import Exchanged, exchanged
from realitygap.diagnose.search.round import Round
from realitygap.diagnose.search.search import needed

PULL = 0.9
"""A constant effort at the elbow besides its friction [N·m], larger than that."""


def test_two_laws_stand_in_the_place_of_one_that_does_the_most_of_both() -> None:
    """Friction by direction is dry friction beside a constant effort that is no larger, while a joint moves."""
    bare = demo_problem()
    names = ("direction_friction", "coulomb_friction", "constant_effort", "viscous_friction")
    both, dry, pull, _ = (guess(bare, suspect_of(bare, name, "elbow")) for name in names)
    lacking = [dry.at({"torque": FRICTION}), pull.at({"effort": PULL})]
    with Simulations(bare, 2) as simulations:
        floors = measure(simulations, [])
    problem = plant_recordings(bare, floors, lacking, "mujoco")
    with Simulations(problem, 2) as simulations:
        left = residual(simulations, [], problem.of("train"))
        assert left is not None
        everyone, nothing = [suspect_of(problem, name, "elbow") for name in names], Fit((), left)
        begun = both.at({"forward": 0.01, "backward": FRICTION + PULL})
        at = Fit((begun,), left)
        round_ = Round(simulations, at, everyone, needed(len(everyone)), nothing, print)
        assert standing(round_.now.fit.changes) == standing([both])
        better = exchanged(round_, [], Exchanged()).better
    assert better is not None
    assert standing(better.fit.changes) == standing(lacking)
    assert better.evidence - round_.now.evidence > round_.limit
