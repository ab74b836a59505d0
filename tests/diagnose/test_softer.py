"""Softer springs are tried as long as the softest of a joint promises most, on the bundled demo (synthetic)."""

import pytest
from demo_problem import demo_problem, planted, suspect_of
from realitygap.diagnose.candidates.starts import SWINGS, guess
from realitygap.diagnose.data.simulations import Simulations
from realitygap.diagnose.search.criterion import Criterion


@pytest.mark.parametrize(("share", "softer"), [(0.3 * SWINGS[-1], True), (SWINGS[4], False)])
def test_softer_springs_are_tried_as_long_as_the_softest_promises_most(share: float, softer: bool) -> None:
    bare = demo_problem()
    spring = guess(bare, suspect_of(bare, "joint_compliance", "elbow"))
    stiffness = spring.parameters["stiffness"]
    problem = planted(spring.at({"stiffness": share * stiffness}))
    with Simulations(problem, 2) as simulations:
        criterion = Criterion(simulations, [])
        bare_model = criterion.fit([])
        assert bare_model is not None
        blocks = criterion.responses(bare_model.fit, [spring.suspect])
    tried = sorted({b.start.stiffness for b in blocks})
    assert tried[-1] == stiffness
    assert (tried[0] < 0.9 * SWINGS[-1] * stiffness) is softer
    if softer:
        assert tried[0] < 1.3 * share * stiffness
        assert len(tried) == len(blocks), "none twice"
