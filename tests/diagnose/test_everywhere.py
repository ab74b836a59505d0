"""What every machine has a little of is named where it is clearly more, on the bundled demo (synthetic)."""

import pytest
from demo_problem import demo_problem, planted, suspect_of
from realitygap.diagnose.candidates.starts import guess
from realitygap.diagnose.candidates.suspects import suspects
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.judge.ordinary import tolerated
from realitygap.diagnose.search.criterion import Criterion
from realitygap.diagnose.search.found import Found
from realitygap.robot.effects import EFFECTS


@pytest.mark.parametrize(("saturation", "named"), [(0.006, False), (0.12, True)])
def test_a_droop_that_motors_have_anyway_is_adjusted_and_a_large_one_is_named(saturation: float, named: bool) -> None:
    """They do 0.03 and 0.6 times what the torque constant does."""
    bare = demo_problem()
    suspect = suspect_of(bare, "motor_saturation", "shoulder")
    missing = guess(bare, suspect).at({"saturation": saturation})
    problem = planted(missing)
    with Simulations(problem, 2) as simulations:
        criterion = Criterion(simulations, [missing])
        best = criterion.fit([missing])
        assert best is not None
        criterion.set_discrepancy(
            best.fit, criterion.responses(best.fit, [s for s in suspects(problem) if s.target == "shoulder"])
        )
        best = criterion.score(best.fit)
        found = Found(best, best, best, 6.0, {}, criterion.floors, criterion, gains={suspect: 500.0})
        told = tolerated(simulations, found, [])
    assert best.fit.changes[0].parameters["saturation"] == pytest.approx(saturation, rel=0.2)
    assert told.adjusted == (() if named else (suspect,))


def test_what_every_machine_has_is_no_effect_that_models_have_a_value_of() -> None:
    assert {e.name for e in EFFECTS.values() if e.everywhere} == {"friction_ripple", "motor_saturation"}
